// Maps that the program registers.
#include <atomic>

#include "evenstep/campaigns/size.h"
#include "evenstep/remap/phase_locked_map.h"
#include "support.h"

using namespace evenstep;
using namespace own_parts;
using Catch::Contains;

namespace {

/// A map of evenstep, wrapped as a map of the program.
struct Wrapped : ForeignMap {
  void boundary(std::int64_t n, RealTime begin) override { map.boundary(n, begin); }
  void began(std::int64_t, RealTime at) override { began_at = at; }
  std::optional<RealTime> slot(std::int64_t n) override {
    const Slot slot = map.read(n, began_at);
    return slot.kind == SlotKind::mapped ? std::optional(slot.read) : std::nullopt;
  }
  void ended(std::int64_t n, RealTime at) override { map.emission(n, at); }
  PhaseLockedMap map{Duration{}, Duration{}, 2.0};
  RealTime began_at;
};

/// A map whose slots the test chooses.
struct ToldMap : ForeignMap {
  explicit ToldMap(std::function<std::optional<RealTime>(std::int64_t)> say) : says(std::move(say)) {}
  void boundary(std::int64_t, RealTime) override {}
  std::optional<RealTime> slot(std::int64_t n) override { return says(n); }
  std::function<std::optional<RealTime>(std::int64_t)> says;
};

Registry with_map(const MapFactory& make) {
  Registry mine = registry();
  mine.add_map("mine", make);
  return mine;
}
Registry told_map(const std::function<std::optional<RealTime>(std::int64_t)>& says) {
  return with_map([says](const MapRequest&) { return std::make_unique<ToldMap>(says); });
}

const std::string kBoth = R"(run.strategies=["phase_locked", "foreign"])";
const std::string kMine = R"(remap.foreign={ name = "mine" })";

}  // namespace

TEST_CASE("A map of the program's gets lead, latency, rings and forces as evenstep's own") {
  for (const char* timing : {"timing.visualization=\"11.1 ms\"", "timing.jitter.visualization=\"lognormal 10 %\""}) {
    INFO(timing);
    for (const char* underrun : {"clamp", "gate", "extrapolate"}) {
      const std::string policy = fmt::format("remap.underrun.interaction=\"{}\"", underrun);
      const RunRecord run = record({timing, policy, kBoth, kMine}, with_map([](const MapRequest& request) {
                                     CHECK(request.step_rate == Rate{450, 1});
                                     return std::make_unique<Wrapped>();
                                   }));
      const StrategyRecord &own = strategy(run, "phase_locked"), &mine = strategy(run, "foreign");
      CHECK(mine.trace_hash == own.trace_hash);
      CHECK(mine.latency.latency == own.latency.latency);
      CHECK(mine.latency.lead == own.latency.lead);
      CHECK(mine.latency.force_capacity == own.latency.force_capacity);
      CHECK(mine.emission_repairs == own.emission_repairs);
    }
  }
}

TEST_CASE("The sizes of a scenario are told for a map of the program's, too") {
  const ReadResult scenario = read({kBoth, kMine}, with_map([](const MapRequest&) { return std::make_unique<Wrapped>(); }));
  REQUIRE(scenario);
  const SizeResult sized = size_scenario(*scenario, {});
  REQUIRE(sized.errors.empty());
  const StrategyPlan own = plan(*scenario)[0], mine = plan(*scenario)[1];
  CHECK(own.latency == mine.latency);
  CHECK_THAT(size_text(sized.record), Contains("foreign"));
}

TEST_CASE("A map gets its options, and one of ten lines runs") {
  const RunRecord run = record({kBoth, R"(remap.foreign={ name = "my-pacer" })"});
  CHECK(strategy(run, "foreign").steps.back().mapped);
  std::string options;
  record({kBoth, R"(remap.foreign={ name = "mine", options = { b = 2, a = [1.5] } })"},
         with_map([&](const MapRequest& request) {
           options = request.options;
           return std::make_unique<Wrapped>();
         }));
  CHECK(options == R"({"a":[1.5],"b":2})");
}

TEST_CASE("A map that fails, or puts a slot out of reach, stops the run with its name") {
  const auto failure = [](const Registry& mine) {
    const RunOutcome outcome = run({kBoth, kMine}, mine);
    CHECK(outcome.exit == ExitCode::run_failed);
    return outcome.failure;
  };
  CHECK_THAT(failure(told_map([](std::int64_t n) -> std::optional<RealTime> {
               return n < 9 ? RealTime{n * 2'222'222} : throw std::runtime_error("lost count");
             })),
             Contains("the map 'mine': lost count"));
  for (const std::int64_t far : {INT64_MAX, INT64_MIN, std::int64_t{100'000'000'000}}) {
    CHECK_THAT(failure(told_map([far](std::int64_t n) { return RealTime{n < 9 ? n * 2'222'222 : far}; })),
               Contains("step 9, which begins at") && Contains(fmt::format("has its slot at {} ns", far)));
  }
  CHECK_THAT(failure(with_map([](const MapRequest&) { return nullptr; })), Contains("its factory returned nothing"));
}

TEST_CASE("A run with --repeat names a map that is not reproducible") {
  RunOptions twice;
  twice.repeat = true;
  std::atomic<int> made{0};
  const Registry mine = with_map([&](const MapRequest&) {
    const int which = made++;
    return std::make_unique<ToldMap>([which](std::int64_t n) { return RealTime{n * 2'222'222 + (n == 50 ? which : 0)}; });
  });
  const RunOutcome outcome = run({kBoth, kMine, "remap.latency=\"50 ms\"", "remap.lead=\"10 ms\""}, mine, twice);
  CHECK(outcome.exit == ExitCode::not_reproducible);
  CHECK_THAT(outcome.repeat_difference, Contains("the map 'mine' gave another slot for step 50"));
}
