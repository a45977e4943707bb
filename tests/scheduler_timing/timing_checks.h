#pragma once
/// The rules for every schedule of segments (SegmentTiming in step_timing.h), and small tools for the timing tests.

#include <algorithm>
#include <cstdint>
#include <vector>

#include "catch.h"
#include "evenstep/scheduler/step_timing.h"
#include "evenstep/time/digest.h"

namespace evenstep {

constexpr std::int64_t ms = 1'000'000;

inline std::vector<SegmentTiming> play(const ProgrammedTiming& programmed, int segments) {
  const auto timing = make_programmed_timing(programmed);
  std::vector<SegmentTiming> played(segments);
  for (SegmentTiming& segment : played) REQUIRE(timing->next(segment));
  return played;
}

inline Duration length(const Interval& interval) { return interval.end - interval.begin; }

/// Visualization and steps must be in order, disjoint and inside the segment, and segments must touch. If the visualization
/// has its own lane, steps are disjoint and in order among themselves, begin in their segment and may end in a later one.
/// Returns the number of violations.
inline std::int64_t disorder(const std::vector<SegmentTiming>& segments) {
  std::int64_t wrong = 0, index = 0;
  RealTime boundary{0}, last{0};
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const SegmentTiming& segment = segments[k];
    const RealTime end = k + 1 < segments.size() ? segments[k + 1].begin : segment.end;
    wrong += segment.index != index++ || segment.begin < boundary || end < segment.begin || segment.end < end;
    if (!segment.concurrent) {
      wrong += segment.begin != boundary || segment.end != end || segment.overlaps();
      last = segment.begin;
    }
    for (const Interval& step : segment.steps) {
      wrong += step.begin < last || step.end <= step.begin || step.end > segment.end;
      wrong += step.begin < segment.begin || step.begin >= end;
      last = step.end;
    }
    if (const auto& visualization = segment.visualization) {
      wrong +=
          visualization->begin < segment.begin || visualization->end > end || visualization->end <= visualization->begin;
    }
    boundary = end;
  }
  return wrong;
}

/// The time within the segment that neither the visualization nor a step fills.
inline Duration idle(const SegmentTiming& segment) {
  Duration rest = segment.end - segment.begin;
  if (segment.visualization) rest = rest - length(*segment.visualization);
  for (const Interval& step : segment.steps) rest = rest - length(step);
  return rest;
}

inline std::vector<Duration> step_durations(const std::vector<SegmentTiming>& segments) {
  std::vector<Duration> durations;
  for (const SegmentTiming& segment : segments) {
    for (const Interval& step : segment.steps) durations.push_back(length(step));
  }
  return durations;
}

inline std::vector<Duration> visualization_durations(const std::vector<SegmentTiming>& segments) {
  std::vector<Duration> durations;
  for (const SegmentTiming& segment : segments) {
    if (segment.visualization) durations.push_back(length(*segment.visualization));
  }
  return durations;
}

inline std::uint64_t digest_of(const std::vector<SegmentTiming>& segments) {
  std::uint64_t digest = 0;
  const auto add = [&digest](std::int64_t word) { digest = mix(digest, static_cast<std::uint64_t>(word)); };
  for (const SegmentTiming& segment : segments) {
    add(segment.index);
    add(segment.begin.ns);
    add(segment.end.ns);
    add(segment.visualization ? segment.visualization->begin.ns : -1);
    add(segment.visualization ? segment.visualization->end.ns : -1);
    for (const Interval& step : segment.steps) {
      add(step.begin.ns);
      add(step.end.ns);
    }
  }
  return digest;
}

}  // namespace evenstep
