// A visualization in its own lane, beside the steps.
#include <cmath>

#include "catch.h"
#include "timing_checks.h"

using namespace evenstep;

namespace {

struct Expected {
  std::int64_t begin;
  std::int64_t visualized;  ///< end of the visualization; -1: none
  std::vector<std::int64_t> step_ends;
};

/// Compares a schedule with the expected times in ms. Steps follow each other from 0 on.
void check(const ProgrammedTiming& timing, const std::vector<Expected>& expected) {
  const auto segments = play(timing, static_cast<int>(expected.size()));
  std::int64_t step_begin = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    INFO("segment " << k);
    const SegmentTiming& segment = segments[k];
    CHECK(segment.begin.ns == expected[k].begin * ms);
    REQUIRE(segment.visualization.has_value() == (expected[k].visualized >= 0));
    if (segment.visualization) {
      CHECK(segment.visualization->begin == segment.begin);
      CHECK(segment.visualization->end.ns == expected[k].visualized * ms);
    }
    REQUIRE(segment.steps.size() == expected[k].step_ends.size());
    for (std::size_t i = 0; i < segment.steps.size(); ++i) {
      CHECK(segment.steps[i].begin.ns == step_begin * ms);
      CHECK(segment.steps[i].end.ns == expected[k].step_ends[i] * ms);
      step_begin = expected[k].step_ends[i];
    }
    CHECK(segment.overlaps());
  }
}

ProgrammedTiming lanes(std::int64_t visualization_ms, std::int64_t step_ms) {
  return {.visualization = {visualization_ms * ms}, .step = Duration{step_ms * ms}, .order = SegmentOrder::concurrent};
}

double mean_steps(const ProgrammedTiming& timing, int segments) {
  std::size_t steps = 0;
  for (const SegmentTiming& segment : play(timing, segments)) steps += segment.steps.size();
  return static_cast<double>(steps) / segments;
}

}  // namespace

TEST_CASE("concurrent: visualizations back to back, steps back to back, a step belongs to the segment it begins in") {
  // Segment 2 begins at 20 ms with the step that begins there. Its last step ends in segment 3.
  check(lanes(10, 4), {{0, 10, {4, 8, 12}}, {10, 20, {16, 20}}, {20, 30, {24, 28, 32}}, {30, 40, {36, 40}}});
}

TEST_CASE("concurrent: where steps are longer than segments, some segments hold none and overlap all the same") {
  check(lanes(10, 25), {{0, 10, {25}}, {10, 20, {}}, {20, 30, {50}}, {30, 40, {}}, {40, 50, {}}, {50, 60, {75}}});
}

TEST_CASE("concurrent and paced: visualizations wait for the grid, and steps that begin beside one are slowed down") {
  ProgrammedTiming timing = lanes(10, 3);
  timing.segment = {50, 1};
  timing.paced = true;
  timing.slowdown = 2;
  // A step that begins at 10 ms, the end of the visualization, would not be slow. The whole step that begins at 6 ms is
  // slow.
  check(timing, {{0, 10, {6, 12, 15, 18, 21}}, {20, 30, {27, 33, 36, 39, 42}}, {40, 50, {48, 54, 57, 60}}});
  timing.dropped_visualization = 1;
  check(timing, {{0, -1, {3, 6, 9, 12, 15, 18, 21}}, {20, -1, {24, 27, 30, 33, 36, 39, 42}}});
}

TEST_CASE("concurrent: a visualization longer than its slot of the grid makes the next one late, not skipped") {
  ProgrammedTiming timing = lanes(10, 8);
  timing.segment = {50, 1};
  timing.paced = true;
  timing.changes = {{.at = {20 * ms}, .visualization = Duration{35 * ms}},
                    {.at = {30 * ms}, .visualization = Duration{10 * ms}}};
  check(timing,
        {{0, 10, {8, 16, 24}}, {20, 55, {32, 40, 48, 56}}, {55, 65, {64, 72}}, {65, 75, {80}}, {80, 90, {88, 96, 104}}});
}

TEST_CASE("concurrent: what fill gives makes the mean number of steps the one asked for") {
  // With pacing, some steps go on beyond an end of V. Per segment they make (c - 1)^2 / (2 c) fewer steps if all phases to V
  // are equally likely, as with 30 % jitter; times 1 + 0.3^2, because a visualization is more likely to begin in a long
  // step. Back to back, all steps begin beside a visualization, and there are no such steps.
  for (const double slowdown : {1.0, 1.5, 2.0}) {
    for (const bool paced : {false, true}) {
      INFO("slowdown " << slowdown << ", paced " << paced);
      const ProgrammedTiming timing{
          .order = SegmentOrder::concurrent, .step_variation = 0.3, .paced = paced, .slowdown = slowdown};
      const double straddling = paced ? 1.09 * (slowdown - 1) * (slowdown - 1) / (2 * slowdown) : 0;
      // N of a segment varies by 0.3 sqrt(15) = 1.2 at most, the mean of 10^4 by 0.012. Five times that is allowed.
      CHECK(std::abs(mean_steps(timing, 10'000) + straddling - 15) < 0.06);
      CHECK(mean_timing(timing).steps == Approx(15).epsilon(1e-6));  // a step is rounded to ns
    }
  }
}

TEST_CASE("concurrent: jitter of the visualization moves segments and no step") {
  ProgrammedTiming timing = lanes(10, 1);
  timing.step_variation = 0.1;
  const auto even = play(timing, 1'000);
  timing.visualization_variation = 0.3;
  const auto varied = play(timing, 1'000);
  auto a = step_durations(even), b = step_durations(varied);
  a.resize(std::min(a.size(), b.size()));
  b.resize(a.size());
  REQUIRE(a.size() > 9'000);
  CHECK(a == b);
}
