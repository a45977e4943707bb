#pragma once
/// What delays the steps of a segment: the visualization, and the waits of a gate.

#include <algorithm>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// Where the visualization makes the steps of a segment wait: before them, after them ("steps-first"), or nowhere.
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

/// A schedule that a gate has pushed back. A step that waits for its sample delays everything after it, until idle time in
/// the schedule absorbs the delay. begin() and end() must be called for each piece (visualization or step) in order.
///
/// `by()` is the current delay. A boundary at real time B would be at B - by() in a schedule without waits, and that is the
/// time the map must be told. Otherwise the map would learn from the waits, and the simulator would slow itself down
/// (reference case with lead 0: segments of 33.33 ms grow to 34.24 ms at 10 % jitter).
class Postponement {
 public:
  /// When a piece that is programmed to begin at `begin` may begin.
  RealTime begin(RealTime begin) {
    by_ = by_ - std::min(by_, std::max(begin - busy_until_, Duration{}));
    return begin + by_;
  }
  /// When a piece that is programmed to end at `end` ends.
  RealTime end(RealTime end) {
    busy_until_ = end;
    return end + by_;
  }
  /// The piece that was about to begin has waited.
  void wait(Duration waited) { by_ = by_ + waited; }
  Duration by() const { return by_; }

 private:
  RealTime busy_until_;  // programmed end of the piece before
  Duration by_;
};

}  // namespace evenstep
