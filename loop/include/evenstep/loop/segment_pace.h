#pragma once
/// What stops the steps of a segment: the visualization, and the waits of a gate.

#include <algorithm>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// Where the visualization stops the steps: before them, after them ("steps-first"), or not at all.
struct Pause {
  bool before_steps = false;
  bool after_steps = false;
  Duration length;
};
inline Pause pause_of(const SegmentTiming& segment, bool own_lane) {
  if (own_lane || !segment.visualization) return {};
  const bool first = segment.steps.empty() || segment.visualization->begin < segment.steps.front().begin;
  return {first, !first, segment.visualization->end - segment.visualization->begin};
}

/// A schedule that a gate has pushed back: a step that waits for its sample delays all that comes after it, and idle time
/// in the schedule takes the delay up again. Pieces (visualizations, steps) are named in order, each once.
///
/// `by()` is what turns real time into work time: a boundary at real B began at B - by() in a schedule without waits. The
/// map must be told that, or it learns from its own waiting and the simulator slows itself down (reference case with lead 0:
/// segments of 33.33 ms grow to 34.24 ms at 10 % jitter).
class Postponement {
 public:
  /// When what is programmed to begin at `begin` may begin.
  RealTime begin(RealTime begin) {
    by_ = by_ - std::min(by_, std::max(begin - busy_until_, Duration{}));
    return begin + by_;
  }
  /// When what is programmed to end at `end` ends.
  RealTime end(RealTime end) {
    busy_until_ = end;
    return end + by_;
  }
  /// The piece that was to begin waited.
  void wait(Duration waited) { by_ = by_ + waited; }
  Duration by() const { return by_; }

 private:
  RealTime busy_until_;  // programmed end of the piece before
  Duration by_;
};

}  // namespace evenstep
