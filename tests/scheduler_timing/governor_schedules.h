#pragma once
// Schedules for the tests of the governor, and what they ask of the governed ones.

#include <numeric>

#include "cases.h"
#include "evenstep/scheduler/frame_governor.h"
#include "evenstep/scheduler/random.h"
#include "timing_checks.h"

namespace evenstep::governor_schedules {

inline constexpr std::int64_t kMs = 1'000'000;
inline constexpr std::uint64_t kSchedules = 2'000;

/// A schedule of 40 arbitrary segments: 0 to 20 steps, drawings of up to 50 ms or none, gaps, free-running or on a grid of
/// 40 ms, drawings before or after the steps.
inline std::vector<SegmentTiming> any_schedule(std::uint64_t seed) {
  const RandomStream random(seed, "governor.test");
  std::uint64_t draw = 0;
  const auto below = [&](std::uint64_t bound) { return static_cast<std::int64_t>(random.below(draw++, bound)); };
  const bool grid = below(2) == 0, steps_first = below(3) == 0;
  std::vector<SegmentTiming> out;
  RealTime at{below(kMs)};
  const RealTime origin = at;
  for (std::int64_t k = 0; k < 40; ++k) {
    if (grid) at = std::max(at, origin + Duration{k * 40 * kMs});
    SegmentTiming segment;
    segment.index = k;
    segment.begin = at;
    const auto draws = [&] {
      if (below(8) == 0) return;
      segment.visualization = Interval{at, at + Duration{1 + below(below(6) == 0 ? 50 * kMs : 12 * kMs)}};
      at = segment.visualization->end;
    };
    if (!steps_first) draws();
    for (std::int64_t i = below(21); i > 0; --i) {
      at = at + Duration{segment.steps.empty() && !segment.visualization ? 0 : below(1000)};
      segment.steps.push_back({at, at + Duration{1 + below(3 * kMs)}});
      at = segment.steps.back().end;
    }
    if (steps_first) draws();
    segment.end = at;
    at = at + Duration{1 + below(1000)};
    out.push_back(segment);
  }
  return out;
}

inline std::vector<SegmentTiming> governed(const std::vector<SegmentTiming>& source, const FrameGovernor& governor,
                                           std::optional<Duration> grid = {}) {
  const auto timing = make_governed_timing(make_replayed_timing(source), governor, grid);
  std::vector<SegmentTiming> out;
  for (SegmentTiming segment; timing->next(segment);) out.push_back(segment);
  return out;
}

inline FrameGovernor any_governor(std::uint64_t seed) {
  const RandomStream random(seed, "governor.kind");
  FrameGovernor governor;
  if (random.below(0, 2) == 0) governor.split = 1 + static_cast<int>(random.below(1, 6));
  if (random.below(2, 4) > 0) governor.budget = Duration{1 + static_cast<std::int64_t>(random.below(3, 20 * kMs))};
  governor.over_budget = static_cast<OverBudget>(random.below(4, 3));
  governor.forecast = static_cast<int>(random.below(5, 4));
  if (random.below(6, 3) == 0) governor.pace = Duration{1 + static_cast<std::int64_t>(random.below(7, 60 * kMs))};
  governor.spread = random.below(8, 2) == 0;
  return governor;
}

inline std::optional<Duration> any_grid(std::uint64_t seed) {
  return RandomStream(seed, "governor.grid").below(0, 2) == 0 ? std::optional(Duration{40 * kMs}) : std::nullopt;
}

inline std::vector<SegmentTiming> governed_replay(const std::vector<SegmentTiming>& recording,
                                                  const FrameGovernor& governor) {
  const auto timing = make_governed_replay(recording, governor);
  std::vector<SegmentTiming> out;
  for (SegmentTiming segment; timing->next(segment);) out.push_back(segment);
  return out;
}

inline std::vector<Interval> steps_of(const std::vector<SegmentTiming>& segments) {
  std::vector<Interval> out;
  for (const SegmentTiming& segment : segments) out.insert(out.end(), segment.steps.begin(), segment.steps.end());
  return out;
}

/// What a simulator with a timer of `period` does: `segments` segments of 1 to 20 steps (all the same number, or any), which
/// wait for their turn or begin late. Drawings take their share of the period, and one in ten up to two periods more. `fit`:
/// no step is longer than its slot; otherwise one in a hundred takes up to a period. `jitter`: of the turns, in 1/1000.
struct Paced {
  Duration period;
  std::vector<SegmentTiming> segments;
};
inline Paced paced_schedule(std::uint64_t seed, bool fit, std::uint64_t jitter = 0, std::int64_t segments = 12) {
  const RandomStream random(seed, "governor.spread");
  std::uint64_t draw = 0;
  const auto below = [&](std::int64_t bound) {
    return static_cast<std::int64_t>(random.below(draw++, static_cast<std::uint64_t>(bound)));
  };
  Paced out{Duration{8 * kMs + below(32 * kMs)}, {}};
  const std::int64_t period = out.period.ns, most = 1 + below(20), share = 1 + below(90), drawing = below(60);
  const bool varies = below(2) == 0;
  RealTime busy;
  for (std::int64_t k = 0; k < segments; ++k) {
    const std::int64_t off = jitter > 0 ? below(period * static_cast<std::int64_t>(jitter) / 1000 + 1) : 0;
    SegmentTiming segment;
    segment.index = k;
    segment.begin = std::max(busy, RealTime{k * period + off});
    RealTime at = segment.begin;
    if (const std::int64_t length = period * drawing / 100 + (below(10) == 0 ? below(2 * period) : 0); length > 0) {
      segment.visualization = Interval{at, at + Duration{length}};
      at = segment.visualization->end;
    }
    const std::int64_t steps = varies ? 1 + below(most) : most;
    for (std::int64_t i = 0; i < steps; ++i) {
      const bool hit = !fit && below(100) == 0;
      const Duration run_time{1 + below(hit ? period : std::max<std::int64_t>(period * share / 100 / steps, 1))};
      segment.steps.push_back({at, at + run_time});
      at = at + run_time;
    }
    segment.end = busy = at;
    out.segments.push_back(segment);
  }
  return out;
}

inline std::int64_t drawn_ns(const std::vector<SegmentTiming>& segments) {
  std::int64_t sum = 0;
  for (const Duration length : visualization_durations(segments)) sum += length.ns;
  return sum;
}

inline Duration longest_pause(const std::vector<SegmentTiming>& segments) {
  Duration longest;
  for (const Duration length : visualization_durations(segments)) longest = std::max(longest, length);
  return longest;
}

inline std::int64_t left_out(const std::vector<SegmentTiming>& segments) {
  return std::count_if(segments.begin(), segments.end(), [](const SegmentTiming& s) { return s.drawing.left_out; });
}

inline std::int64_t finished(const std::vector<SegmentTiming>& segments) {
  return std::count_if(segments.begin(), segments.end(),
                       [](const SegmentTiming& s) { return s.visualization && s.drawing.finishes; });
}

inline std::int64_t drawings(const std::vector<SegmentTiming>& segments) {
  return static_cast<std::int64_t>(visualization_durations(segments).size());
}

/// The number of things that are not in the order of time.
inline std::int64_t out_of_order(const std::vector<SegmentTiming>& segments) {
  std::int64_t wrong = 0;
  RealTime last = segments.front().begin;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const SegmentTiming& segment = segments[k];
    wrong += segment.index != static_cast<std::int64_t>(k) || segment.begin < last || segment.overlaps();
    last = segment.begin;
    std::vector<Interval> pieces = segment.steps;
    if (segment.visualization) {
      const bool first = pieces.empty() || segment.visualization->begin <= pieces.front().begin;
      pieces.insert(first ? pieces.begin() : pieces.end(), *segment.visualization);
    }
    for (const Interval& piece : pieces) {
      wrong += piece.begin < last || piece.end < piece.begin;
      last = piece.end;
    }
    wrong += segment.end < last;
  }
  return wrong;
}

/// Visualizations of these lengths, each followed by 4 steps of 1 ms, without gaps.
inline std::vector<SegmentTiming> free_running(const std::vector<std::int64_t>& visualizations_ms) {
  std::vector<SegmentTiming> out;
  RealTime at;
  for (const std::int64_t visualization : visualizations_ms) {
    SegmentTiming segment;
    segment.index = std::ssize(out);
    segment.begin = at;
    segment.visualization = Interval{at, at + Duration{visualization * kMs}};
    at = segment.visualization->end;
    for (int i = 0; i < 4; ++i, at = at + Duration{kMs}) segment.steps.push_back({at, at + Duration{kMs}});
    segment.end = at;
    out.push_back(segment);
  }
  return out;
}

inline std::vector<std::int64_t> pauses_ms(const std::vector<SegmentTiming>& segments) {
  std::vector<std::int64_t> out;
  for (const SegmentTiming& segment : segments)
    out.push_back(segment.visualization ? length(*segment.visualization).ns / kMs : 0);
  return out;
}

}  // namespace evenstep::governor_schedules
