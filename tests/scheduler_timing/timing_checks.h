#pragma once
/// What every schedule of segments must satisfy (SegmentTiming in step_timing.h), and small tools of the timing tests.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "evenstep/scheduler/step_timing.h"
#include "evenstep/time/digest.h"

namespace evenstep {

inline std::vector<SegmentTiming> play(const ProgrammedTiming& programmed, int segments) {
  const auto timing = make_programmed_timing(programmed);
  std::vector<SegmentTiming> played(segments);
  for (SegmentTiming& segment : played) REQUIRE(timing->next(segment));
  return played;
}

inline Duration length(const Interval& interval) { return interval.end - interval.begin; }

/// In order, disjoint, inside the segment; the segments touch. Returns the number of violations.
inline std::int64_t disorder(const std::vector<SegmentTiming>& segments) {
  std::int64_t wrong = 0;
  RealTime boundary{0};
  std::int64_t index = 0;
  for (const SegmentTiming& segment : segments) {
    wrong += segment.index != index++ || segment.begin != boundary || segment.end < segment.begin || segment.overlaps();
    RealTime last = segment.begin;
    for (const Interval& step : segment.steps) {
      wrong += step.begin < last || step.end <= step.begin;
      last = step.end;
    }
    wrong += last > segment.end;
    if (const auto& visualization = segment.visualization) {
      wrong += visualization->begin < segment.begin || visualization->end > segment.end ||
               visualization->end <= visualization->begin;
    }
    boundary = segment.end;
  }
  return wrong;
}

/// Time between `begin` and `end` that neither the visualization nor a step fills.
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
