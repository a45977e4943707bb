// Schedules that can be worked out by hand: visualization and steps take turns, one model at a time.
#include "catch.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

/// V = 10 ms and two steps of 4 ms.
ProgrammedTiming plain() { return {.visualization = {10 * ms}, .steps = {2}, .step = Duration{4 * ms}}; }

/// Begin and end of visualization ("V") and steps ("s") of each segment, in us: "0 V 0 10000 s 10000 14000 ... | ..."
std::string text(const std::vector<SegmentTiming>& segments) {
  std::string out;
  const auto add = [&out](char kind, const Interval& interval) {
    out += std::string(1, kind) + " " + std::to_string(interval.begin.ns / 1000) + " " +
           std::to_string(interval.end.ns / 1000) + " ";
  };
  for (const SegmentTiming& segment : segments) {
    out += std::to_string(segment.begin.ns / 1000) + ": ";
    if (segment.visualization) add('V', *segment.visualization);
    for (const Interval& step : segment.steps) add('s', step);
    out += "| ";
  }
  return out + std::to_string(segments.back().end.ns / 1000);
}

std::vector<std::int64_t> begins_us(const std::vector<SegmentTiming>& segments) {
  std::vector<std::int64_t> out;
  for (const SegmentTiming& segment : segments) out.push_back(segment.begin.ns / 1000);
  return out;
}

}  // namespace

TEST_CASE("the first step after a visualization is longer by first_step, the others are not") {
  ProgrammedTiming timing = plain();
  timing.first_step = 0.25;
  CHECK(text(play(timing, 2)) ==
        "0: V 0 10000 s 10000 15000 s 15000 19000 | 19000: V 19000 29000 s 29000 34000 s 34000 38000 | 38000");
  timing.order = SegmentOrder::steps_first;  // step 0 follows no visualization
  CHECK(text(play(timing, 2)) ==
        "0: V 8000 18000 s 0 4000 s 4000 8000 | 18000: V 27000 37000 s 18000 23000 s 23000 27000 | 37000");
  timing.dropped_visualization = 1;
  CHECK(text(play(timing, 2)) == "0: s 0 4000 s 4000 8000 | 8000: s 8000 12000 s 12000 16000 | 16000");
}

TEST_CASE("a dropped visualization leaves no gap, a merged one is twice as long") {
  ProgrammedTiming timing = plain();
  timing.dropped_visualization = 1;
  CHECK(text(play(timing, 2)) == "0: s 0 4000 s 4000 8000 | 8000: s 8000 12000 s 12000 16000 | 16000");
  timing.dropped_visualization = 0;
  timing.merged_visualization = 1;
  CHECK(text(play(timing, 2)) ==
        "0: V 0 20000 s 20000 24000 s 24000 28000 | 28000: V 28000 48000 s 48000 52000 s 52000 56000 | 56000");
}

TEST_CASE("drift scales every duration of a segment by 1 + r B, and may go down") {
  ProgrammedTiming timing{.visualization = {100 * ms}, .steps = {1}, .step = Duration{100 * ms}, .drift_per_s = 0.1};
  // B = 0, 0.2, 0.2 + 2 * 0.102 = 0.404, 0.404 + 2 * 0.10404 = 0.61208 s
  CHECK(text(play(timing, 3)) ==
        "0: V 0 100000 s 100000 200000 | 200000: V 200000 302000 s 302000 404000 | "
        "404000: V 404000 508040 s 508040 612080 | 612080");
  timing.drift_per_s = -0.1;  // B_2 = 0.2 + 2 * 0.098 s
  CHECK(text(play(timing, 3)) ==
        "0: V 0 100000 s 100000 200000 | 200000: V 200000 298000 s 298000 396000 | "
        "396000: V 396000 492040 s 492040 588080 | 588080");
}

TEST_CASE("a drift that has used up all time leaves 1 ns per duration: time never stands still or runs back") {
  const ProgrammedTiming timing{.visualization = {10 * ms}, .steps = {2}, .step = Duration{4 * ms}, .drift_per_s = -10};
  const auto segments = play(timing, 20'000);
  CHECK(disorder(segments) == 0);
  CHECK(segments.back().end - segments.back().begin == Duration{3});
}

TEST_CASE("a change holds from the first segment that begins at its time, not 1 ns before") {
  ProgrammedTiming timing = plain();
  timing.changes = {{.at = {18 * ms}, .visualization = Duration{20 * ms}}};
  CHECK(begins_us(play(timing, 4)) == std::vector<std::int64_t>{0, 18'000, 46'000, 74'000});
  timing.changes[0].at.ns += 1;
  CHECK(begins_us(play(timing, 4)) == std::vector<std::int64_t>{0, 18'000, 36'000, 64'000});
}

TEST_CASE("changes add up, each touches only what it names, and several may fall into one segment") {
  ProgrammedTiming timing = plain();
  timing.changes = {{.at = {1}, .visualization = Duration{20 * ms}},
                    {.at = {2}, .step = Duration{5 * ms}},
                    {.at = {50 * ms}, .steps = {3}},
                    {.at = {100 * ms}, .visualization = Duration{0}}};
  CHECK(text(play(timing, 5)) ==
        "0: V 0 10000 s 10000 14000 s 14000 18000 | 18000: V 18000 38000 s 38000 43000 s 43000 48000 | "
        "48000: V 48000 68000 s 68000 73000 s 73000 78000 | "
        "78000: V 78000 98000 s 98000 103000 s 103000 108000 s 108000 113000 | "
        "113000: s 113000 118000 s 118000 123000 s 123000 128000 | 128000");
}

TEST_CASE("fill keeps its step when the visualization changes: the segment grows by as much") {
  ProgrammedTiming timing{.changes = {{.at = {1'000 * ms}, .visualization = Duration{22'200'000}}}};
  const auto segments = play(timing, 60);
  for (const SegmentTiming& segment : segments) {
    const bool before = segment.begin.ns < 1'000 * ms;
    for (const Interval& step : segment.steps) REQUIRE(length(step).ns == 1'482'222);
    CHECK((segment.end - segment.begin).ns == 15 * 1'482'222 + (before ? 11'100'000 : 22'200'000));
  }
}

TEST_CASE("paced: a segment waits for its tick, after a late one none waits until the grid is caught up, none is skipped") {
  ProgrammedTiming timing = plain();
  timing.segment = {50, 1};
  timing.paced = true;
  timing.changes = {{.at = {20 * ms}, .visualization = Duration{30 * ms}},
                    {.at = {60 * ms}, .visualization = Duration{10 * ms}}};
  const auto segments = play(timing, 40);
  CHECK(disorder(segments) == 0);
  // Segments take 18, 38, 38 ms and then 18 ms again. So segment 3 is 36 ms behind the grid, and each further one 2 ms less.
  for (const SegmentTiming& segment : segments) {
    const std::int64_t k = segment.index, behind = k < 2 ? 0 : k == 2 ? 18 : std::max<std::int64_t>(0, 36 - 2 * (k - 3));
    CHECK(segment.begin.ns == (20 * k + behind) * ms);
    CHECK(idle(segment).ns == (k == 0 || k >= 21 ? 2 * ms : 0));
  }
}

TEST_CASE("paced with a tick that is no whole ns waits for floor(k T) over 10^5 segments") {
  const ProgrammedTiming timing{.step = Duration{1'000'000}, .step_variation = 0.01, .paced = true};
  for (const SegmentTiming& segment : play(timing, 100'000)) REQUIRE(segment.begin == tick_time({30, 1}, segment.index));
}

TEST_CASE("paced, steps first: the visualization ends at the next tick if it can, and follows the steps if not") {
  ProgrammedTiming timing = plain();
  timing.segment = {50, 1};
  timing.paced = true;
  timing.order = SegmentOrder::steps_first;
  timing.changes = {{.at = {20 * ms}, .visualization = Duration{14 * ms}},
                    {.at = {30 * ms}, .visualization = Duration{5 * ms}}};
  CHECK(text(play(timing, 4)) ==
        "0: V 10000 20000 s 0 4000 s 4000 8000 | 20000: V 28000 42000 s 20000 24000 s 24000 28000 | "
        "42000: V 55000 60000 s 42000 46000 s 46000 50000 | 60000: V 75000 80000 s 60000 64000 s 64000 68000 | 80000");
}

TEST_CASE("paced changes nothing where nothing varies") {
  for (const auto order : {SegmentOrder::visualization_first, SegmentOrder::steps_first}) {
    const ProgrammedTiming plain_fill{.order = order};
    ProgrammedTiming paced = plain_fill;
    paced.paced = true;
    CHECK(digest_of(play(paced, 1'000)) == digest_of(play(plain_fill, 1'000)));
  }
}

TEST_CASE("a model that is there without effect gives the free-running schedule of no variation") {
  ProgrammedTiming without = plain(), with = plain();
  without.steps = {2, 2};
  with.regimes = Regimes{1, 3};
  with.spikes = Spikes{0, {4 * ms}};
  with.preemption = Preemption{0, {3 * ms}, {40 * ms}, 1.5};
  CHECK(digest_of(play(with, 1'000)) == digest_of(play(without, 1'000)));
}
