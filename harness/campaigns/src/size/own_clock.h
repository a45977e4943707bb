#pragma once
/// Whether the steps of a recording follow a clock of their own, as those of a game's loop do: each frame runs the steps
/// that are due when it begins.

#include <vector>

#include "evenstep/reports/size_record.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

/// With dt the step size and t(n) the simulation time of step n, let r_k = B_k - t - dt of the last step of frame k: by how
/// much the loop is behind its own beginning once it has caught up. A loop that runs what is due has all r_k within one dt,
/// and one with hysteresis within two. So the steps follow a clock if all r_k lie within two dt.
///
/// Segments without t(n) get it: t(n) = m dt, m = n plus what was dropped before. Where r_k is more than two dt above the
/// least r so far and more than one above r_(k-1) (so it does not creep there, as with another step size), whole steps were
/// dropped before that frame, as many as bring r_k within one dt of the least. If that happens in more than a tenth of the
/// frames, or the steps follow no clock, the segments are left without t(n).
SizeClock follow_clock(std::vector<SegmentTiming>& segments, Rate step_rate);

}  // namespace evenstep::internal
