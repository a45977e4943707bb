// Timing sources that the program registers.
#include <atomic>

#include "evenstep/campaigns/shrink.h"
#include "evenstep/campaigns/sweep.h"
#include "support.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;

namespace {

const std::string kMyGpu = R"(timing={ foreign = { name = "my-gpu" } })";

/// Plays these segments.
struct ToldTiming : StepTiming {
  explicit ToldTiming(std::vector<SegmentTiming> told) : segments(std::move(told)) {}
  bool next(SegmentTiming& segment) override {
    if (k == segments.size()) return false;
    segment = segments[k++];
    return true;
  }
  std::vector<SegmentTiming> segments;
  std::size_t k = 0;
};

SegmentTiming segment(std::int64_t begin, std::vector<Interval> steps, std::int64_t end) {
  return {0, RealTime{begin}, std::nullopt, std::move(steps), RealTime{end}};
}
Interval step(std::int64_t begin, std::int64_t end) { return {RealTime{begin}, RealTime{end}}; }

Registry told_timing(const std::vector<SegmentTiming>& segments) {
  Registry mine = registry();
  mine.add_timing("mine", [segments](const TimingRequest&) { return std::make_unique<ToldTiming>(segments); });
  return mine;
}

}  // namespace

TEST_CASE("A source that gives figure 1's times gives figure 1's trace") {
  const RunRecord mine = record({kMyGpu}), own = record({});
  CHECK(mine.trace_hash == own.trace_hash);
  CHECK(mine.nominal.slot_s == own.nominal.slot_s);
}

TEST_CASE("A source draws by the seed of the run, and varies with it") {
  const std::string jitter = R"(timing={ foreign = { name = "my-gpu", options = { jitter = 0.1 } } })";
  const auto hash = [&](int seed) { return record({jitter, fmt::format("run.seed={}", seed)}).trace_hash; };
  CHECK(hash(1) == hash(1));
  CHECK(hash(1) != hash(2));
}

TEST_CASE("A source that breaks a rule of time is refused, with the segment and the rule") {
  const auto error = [](const std::vector<SegmentTiming>& segments) {
    return errors_of({R"(timing={ foreign = { name = "mine" } })"}, told_timing(segments));
  };
  const SegmentTiming good = segment(0, {step(0, 500)}, 1000);
  CHECK_THAT(error({segment(1, {}, 10)}), Contains("segment 0 begins at 1 ns, and the first must begin at 0 ns"));
  CHECK_THAT(error({good, segment(0, {}, 10)}), Contains("segment 1 begins at 0 ns, not after the one before it at 0 ns"));
  CHECK_THAT(error({good, segment(1000, {step(900, 1100)}, 2000)}), Contains("a step begins at 900 ns, before 1000 ns"));
  CHECK_THAT(error({segment(0, {step(0, 1500)}, 1500), segment(1000, {step(1400, 1600)}, 2000)}),
             Contains("segment 1 a step begins at 1400 ns, before 1500 ns"));
  CHECK_THAT(error({segment(0, {step(10, 5)}, 1000)}), Contains("a step ends at 5 ns, before it begins at 10 ns"));
  CHECK_THAT(error({segment(0, {step(0, 50)}, 40)}), Contains("ends at 40 ns, before its last piece at 50 ns"));
  CHECK_THAT(error({segment(0, {step(0, INT64_MAX)}, INT64_MAX)}), Contains("beyond 4000000000000000000 ns"));
  CHECK_THAT(error({segment(0, {}, 1000)}), Contains("it has no step"));
  CHECK_THAT(error({}), Contains("it has no step"));
  CHECK_THAT(error({good}), Contains("the timing source 'mine' ends at"));  // long before the run
}

TEST_CASE("A source that fails, or is another one each time, is refused with its name") {
  const auto error = [](const TimingFactory& make) {
    Registry mine;
    mine.add_timing("mine", make);
    return errors_of({R"(timing={ foreign = { name = "mine" } })"}, mine);
  };
  CHECK_THAT(error([](const TimingRequest&) { return nullptr; }),
             Contains("the timing source 'mine': its factory returned nothing"));
  CHECK_THAT(error([](const TimingRequest&) -> std::unique_ptr<StepTiming> { throw std::runtime_error("no file"); }),
             Contains("the timing source 'mine': no file"));
  std::atomic<std::uint64_t> asked{0};
  CHECK_THAT(error([&](const TimingRequest&) {
               ProgrammedTiming timing;
               timing.visualization_variation = 0.1;
               timing.seed = ++asked;
               return make_programmed_timing(timing);
             }),
             Contains("the timing source 'mine': segment 0 is another one when it is asked again with the same seed"));
}

TEST_CASE("A source is all of [timing], and the run says how long it lasts") {
  CHECK_THAT(errors_of({kMyGpu, "timing.steps=15"}, registry()), Contains("'steps' does not go with 'foreign'"));
  CHECK_THAT(errors_of({kMyGpu, "timing.trace=\"x.csv\""}, registry()), Contains("remove one of them"));
  CHECK_THAT(errors_of({kMyGpu, "run.duration=\"30 segments\""}, registry()), Contains("write duration = \"4 s\""));
}
