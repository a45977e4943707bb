#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "catch.h"
#include "evenstep/reports/pace.h"
#include "evenstep/reports/pause_parts.h"
#include "evenstep/reports/run_record.h"

using namespace evenstep;
using Catch::Contains;

namespace {

constexpr std::int64_t us = 1'000;

struct Segment {
  Interval time;
  std::optional<Interval> drawing;
  std::vector<Interval> steps;
};

/// A loop with a grid of 33.3 ms: it draws, makes its steps in a burst, and waits for the next frame.
std::vector<Segment> bursts(std::int64_t drawing_us, std::int64_t step_us, bool waits) {
  std::vector<Segment> out;
  for (std::int64_t k = 0; k < 100; ++k) {
    RealTime at{k * 33'300 * us};
    Segment segment{{at, {}}, Interval{at, at + Duration{drawing_us * us}}, {}};
    at = segment.drawing->end;
    for (int i = 0; i < 15; ++i) {
      segment.steps.push_back({at, at + Duration{step_us * us}});
      at = segment.steps.back().end;
    }
    segment.time.end = waits ? RealTime{(k + 1) * 33'300 * us} : at;
    out.push_back(segment);
  }
  return out;
}

PauseParts parts_of(const std::vector<Segment>& segments, bool beside = false) {
  LongestPause longest;
  for (const Segment& one : segments) longest.add_segment(one.time, one.drawing, one.steps, beside);
  return longest.parts();
}

Pace pace_of_all(const std::vector<Segment>& segments, double step_s) {
  Pace pace{.step_s = step_s};
  for (const Segment& one : segments) pace.add_segment(one.time, one.steps);
  return pace;
}

StrategyRecord run_of(const std::vector<Segment>& segments) {
  StrategyRecord strategy;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    SegmentRow& row = strategy.segments.emplace_back();
    row.index = static_cast<std::int64_t>(k);
    row.begin = segments[k].time.begin;
    row.end = segments[k].time.end;
    if (segments[k].drawing) row.visualization = {segments[k].drawing->begin, segments[k].drawing->end};
    for (const Interval& step : segments[k].steps) {
      StepRow& step_row = strategy.steps.emplace_back();
      step_row.segment = row.index;
      step_row.begin = step.begin;
      step_row.end = step.end;
    }
  }
  return strategy;
}

}  // namespace

TEST_CASE("a pause is drawing and waiting where the recording says so, and what it does not say is not called waiting") {
  const PauseParts fast = parts_of(bursts(2'100, 160, true));
  CHECK(fast.length.ns == (33'300 - 15 * 160) * us);
  CHECK(fast.drawing.ns == 2'100 * us);
  CHECK(fast.waiting == fast.length - fast.drawing);
  CHECK(fast.unrecorded.ns == 0);
  CHECK(text(fast) == "Of the longest pause, 30.9 ms, 2.1 are drawing, 28.8 are waiting. The steps take 2.4 of 33.3 ms.");
  const PauseParts silent = parts_of(bursts(2'100, 160, false));
  CHECK(silent.unrecorded == fast.waiting);
  CHECK(text(silent) == "Of the longest pause, 30.9 ms, 2.1 are drawing, 28.8 are not recorded (waiting, or other work).");
  const PauseParts full = parts_of(bursts(11'100, 1'480, true));
  CHECK(text(full) == "Of the longest pause, 11.1 ms, 11.1 are drawing.");
  CHECK_FALSE(full.is_material(full.waiting));
  // A drawing in a lane of its own keeps no step from running.
  CHECK(parts_of(bursts(2'100, 160, true), true).drawing.ns == 0);
  CHECK(text(PauseParts{}).empty());
}

TEST_CASE("in 2000 random loops the parts are the whole pause before the step that ends latest after the one before began") {
  std::mt19937_64 random(1);
  const auto below = [&](std::uint64_t n) { return static_cast<std::int64_t>(random() % n); };
  for (int round = 0; round < 2000; ++round) {
    std::vector<Segment> segments;
    std::vector<Interval> all;
    RealTime at;
    for (int k = 0; k < 12; ++k) {
      Segment segment{{at, {}}, std::nullopt, {}};
      const auto draw_now = [&] {
        segment.drawing = Interval{at, at + Duration{below(9) * us}};
        at = segment.drawing->end + Duration{below(3) * us};
      };
      const bool first = below(2) == 0, draws = below(3) > 0;
      if (draws && first) draw_now();
      for (std::int64_t i = below(4); i > 0; --i) {
        segment.steps.push_back({at, at + Duration{(1 + below(5)) * us}});
        all.push_back(segment.steps.back());
        at = segment.steps.back().end + Duration{below(2) * us};
      }
      if (draws && !first) draw_now();
      segment.time.end = at = at + Duration{below(5) * us};
      segments.push_back(segment);
    }
    Duration needs, length;
    for (std::size_t n = 1; n < all.size(); ++n) {
      if (all[n].end - all[n - 1].begin <= needs) continue;
      needs = all[n].end - all[n - 1].begin;
      length = all[n].begin - all[n - 1].end;
    }
    const PauseParts parts = parts_of(segments);
    REQUIRE(parts.length == length);
    REQUIRE(parts.drawing + parts.waiting + parts.unrecorded == length);
    REQUIRE(std::min({parts.drawing, parts.waiting, parts.unrecorded}).ns >= 0);
    const PauseParts of_run = longest_pause(run_of(segments));
    REQUIRE(of_run.length == length);
    REQUIRE(of_run.drawing == parts.drawing);
    REQUIRE(of_run.waiting == parts.waiting);
  }
}

TEST_CASE("simulated time that passes 12.8 times as fast as real time is said with what would keep it, and 1 % is not") {
  const std::vector<Segment> segments = bursts(2'100, 160, true);  // 15 steps in 33.3 ms
  CHECK(text(pace_of_all(segments, 2.22e-3)).empty());
  CHECK(text(pace_of_all(segments, 2.22e-3 * 1.0099)).empty());
  CHECK_FALSE(text(pace_of_all(segments, 2.22e-3 * 1.02)).empty());
  const Pace fast = pace_of_all(segments, 12.8 * 2.22e-3);
  CHECK(fast.simulated_per_real() == Approx(12.8).epsilon(0.01));  // to a burst in 100
  CHECK_THAT(text(fast), Contains("passes 12.9 times as fast as real time: to a hand all that moves is too fast") &&
                             Contains("a step size of 2.2") && Contains("pace = \"426.2 ms\""));
  const std::string slow = text(pace_of_all(segments, 0.5 * 2.22e-3));
  CHECK_THAT(slow, Contains("too slow") && !Contains("pace ="));
  CHECK(text(pace_of_all({segments[0], segments[1]}, 1)).empty());
  CHECK(text(Pace{.step_s = 1}).empty());

  StrategyRecord run = run_of(segments);
  CHECK(text(pace_of(run, 12.8 * 2.22e-3)) == text(fast));
  run.variable_step = true;
  CHECK(text(pace_of(run, 12.8 * 2.22e-3)).empty());
}
