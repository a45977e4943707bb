#pragma once
/// Recordings for the tests of this folder.

#include <cmath>
#include <string_view>

#include "catch.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/scheduler/random.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::testing {

inline constexpr std::int64_t ms = 1'000'000;

inline std::vector<SegmentTiming> play(const ProgrammedTiming& programmed, std::size_t count) {
  const auto timing = make_programmed_timing(programmed);
  std::vector<SegmentTiming> segments(count);
  for (SegmentTiming& segment : segments) REQUIRE(timing->next(segment));
  return segments;
}

inline const SizeStrategy& strategy(const SizeRecord& record, std::string_view name) {
  for (const SizeStrategy& one : record.strategies) {
    if (one.name == name) return one;
  }
  FAIL("no strategy " << name);
  return record.strategies.front();
}

/// Free running or paced, with jitter, spikes and dropped visualizations, by seed.
inline ProgrammedTiming random_timing(std::uint64_t seed) {
  const RandomStream stream(seed, "size.test");
  std::uint64_t draw = 0;
  const auto pick = [&](std::uint64_t count) { return stream.bits(draw++) % count; };
  ProgrammedTiming timing;
  timing.seed = seed + 1;
  timing.visualization = {static_cast<std::int64_t>(pick(20) + 1) * ms};
  timing.steps = {static_cast<int>(pick(20)) + 1};
  timing.step = Duration{static_cast<std::int64_t>(pick(1900) + 100) * 1000};
  timing.visualization_variation = 0.01 * static_cast<double>(pick(20));
  timing.step_variation = 0.01 + 0.01 * static_cast<double>(pick(20));
  if (pick(3) == 0) timing.spikes = Spikes{10, {4 * ms}};
  if (pick(4) == 0) timing.dropped_visualization = 0.05;
  timing.paced = pick(2) == 0;
  return timing;
}

}  // namespace evenstep::testing
