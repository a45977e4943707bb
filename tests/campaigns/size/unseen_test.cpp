// A size on what it has not seen: compared with sizing the first part alone and counting a run of the part after it.
#include "src/size/unseen.h"

#include "evenstep/harness/underrun_rate.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::internal;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

/// Of the segments whose steps begin before.
SizeRecord sized_before(const std::vector<SegmentTiming>& segments, RealTime from) {
  std::vector<SegmentTiming> part;
  for (const SegmentTiming& segment : segments) {
    if (segment.steps.front().begin < from) part.push_back(segment);
  }
  return size_segments(part, "", {});
}

}  // namespace

TEST_CASE("the size of a first part is what sizing that part alone gives for every map and place") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    ProgrammedTiming timing = random_timing(seed);
    timing.step_variation += 0.1;
    const std::vector<SegmentTiming> segments = play(timing, 130);
    const SizeRecord whole = size_segments(segments, "", {});
    for (const SizeStrategy& one : whole.strategies) {
      REQUIRE(one.unseen.size() == 5);
      std::int64_t played = 0;
      for (const SizeUnseen& unseen : one.unseen) {
        INFO("seed " << seed << ", " << one.name << " from " << unseen.from.ns);
        const SizeStrategy& alone = strategy(sized_before(segments, unseen.from), one.name);
        CHECK(unseen.latency == alone.any_phase.latency);
        CHECK(unseen.lead == alone.lead);
        CHECK((unseen.late == 0) == (unseen.late_by.ns == 0 && unseen.missing_by.ns == 0));
        played += unseen.played;
      }
      CHECK(one.unseen.front().sized + played == 129);  // the first segment of all is not mapped
    }
  }
}

TEST_CASE("what is late in an unseen part is the count of the segments that need more than all before") {
  const RandomStream stream(4, "unseen.test");
  std::uint64_t draw = 0;
  for (int round = 0; round < 300; ++round) {
    std::vector<SegmentNeed> needs(kLeastUnseen + static_cast<std::int64_t>(stream.bits(draw++) % 50));
    for (std::size_t k = 0; k < needs.size(); ++k) {
      needs[k] = {{static_cast<std::int64_t>(stream.bits(draw++) % 90) - 20},
                  {static_cast<std::int64_t>(stream.bits(draw++) % 90) - 20},
                  {static_cast<std::int64_t>(k)}};
    }
    for (const SizeUnseen& unseen : play_unseen(needs)) {
      std::int64_t late = 0, late_by = 0, missing_by = 0;
      for (std::int64_t k = unseen.sized; k < unseen.sized + unseen.played; ++k) {
        const SegmentNeed& need = needs[static_cast<std::size_t>(k)];
        late += need.lead > unseen.lead || need.delay > unseen.latency - unseen.lead ? 1 : 0;
        late_by = std::max(late_by, (need.delay - (unseen.latency - unseen.lead)).ns);
        missing_by = std::max(missing_by, (need.lead - unseen.lead).ns);
      }
      REQUIRE(unseen.from.ns == unseen.sized);
      REQUIRE(unseen.late == late);
      REQUIRE(unseen.late_by.ns == late_by);
      REQUIRE(unseen.missing_by.ns == missing_by);
    }
  }
}

TEST_CASE("a recording that gets worse is late in its last part and the conclusion says by how much") {
  std::vector<SegmentTiming> segments = play({.step_variation = 0.01, .seed = 3}, 120);
  SegmentTiming& hitch = segments[110];
  const Duration longer{25 * ms};
  hitch.steps.back().end = hitch.steps.back().end + longer;
  hitch.end = hitch.end + longer;
  for (std::size_t k = 111; k < segments.size(); ++k) {
    SegmentTiming& segment = segments[k];
    segment.begin = segment.begin + longer;
    segment.end = segment.end + longer;
    if (segment.visualization)
      *segment.visualization = {segment.visualization->begin + longer, segment.visualization->end + longer};
    for (Interval& step : segment.steps) step = {step.begin + longer, step.end + longer};
  }
  const SizeRecord record = size_segments(segments, "", {});
  const SizeStrategy& use = strategy(record, "phase_locked");
  for (std::size_t part = 0; part < 4; ++part) CHECK(use.unseen[part].late_by < Duration{2 * ms});
  CHECK(use.unseen[4].late > 0);
  CHECK(use.unseen[4].late_by > Duration{20 * ms});
  CHECK(use.all_unseen().late_by == use.unseen[4].late_by);
  CHECK_THAT(size_text(record), Contains("it is late in") && Contains("Expect the like of the next recording"));
  CHECK_THAT(size_json(record), Contains("\"unseen\":[{"));
}

TEST_CASE("fewer than sixty segments are not played on unseen parts and the text says so") {
  const auto segments = play({.step_variation = 0.1, .seed = 5}, 60);  // the first acquires
  const SizeRecord few = size_segments(segments, "", {});
  for (const SizeStrategy& one : few.strategies) CHECK(one.unseen.empty());
  CHECK_THAT(size_text(few), Contains("Too short to be sized on a part and played on the next: that takes 60 segments"));
  CHECK_THAT(size_json(few), Contains("\"unseen\":[]"));
  for (const SizeStrategy& one : size_segments(play({.step_variation = 0.1, .seed = 5}, 61), "", {}).strategies)
    CHECK(one.unseen.size() == 5);
}

TEST_CASE("the rate of polyphase has the latency that it needs beyond its map") {
  const auto segments = play({.step_variation = 0.1, .seed = 5}, 80);
  SizeOptions options{.rate = 1e-6};  // none may be late
  options.other_maps = true;
  const SizeRecord record = size_segments(segments, "", options);
  for (const SizeStrategy& one : record.strategies) {
    INFO(one.name);
    CHECK(one.rate->any_phase.latency == one.any_phase.latency);
  }
}
