#pragma once
/// Segments for a plain list of steps, which has none.

#include <cstdint>
#include <vector>

#include "evenstep/remap/step_cycle.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// The cycle of all steps of these segments, found in their times alone.
StepCycle cycle_of(const std::vector<SegmentTiming>& segments);

struct CutSteps {
  std::vector<SegmentTiming> segments;
  std::int64_t left_out = 0;  ///< steps before the first segment
};
/// The segments of the cycle that was found in these steps; if none was, each step is a segment. If a list begins in the
/// middle of a cycle, the steps before the first long pause are left out.
CutSteps cut_steps(const std::vector<Interval>& steps, const StepCycle& cycle);

}  // namespace evenstep
