#pragma once
/// Least latency of any path whose velocity jump is bounded: what lies between the best line (no jump) and the taut string
/// (any jump) of buffer_oracle.h. Like them it knows the whole trace in advance, so no causal map can do with less at that
/// jump.
///
/// A path R(0), R(1), ... through the tube E_n - L <= R(n) <= S_n that never steps back and whose velocity jump is at most
/// a:  |R(n+1) - 2 R(n) + R(n-1)| <= a  ns. The least such L falls with a, from that of the best line at a = 0 to that of
/// the least path. (In steps the jump is a / slot, with the mean slot of the trace.)
///
/// Method: bisection on L. For one L the states (R(n), R(n) - R(n-1)) that a path can be in at step n form a convex
/// polygon: the one of step n-1, sheared (R grows by the velocity), widened by -a to a in both coordinates (the jump), and
/// cut to the tube. A path exists iff no polygon is empty. Corners are integers of 2^-20 ns or finer (coarser only for
/// traces longer than a quarter of an hour), and are rounded inwards where an edge is cut, so a path always exists at the
/// L returned; a test compares it with an independent linear program. O(n c) per trial of L, with c corners: a few dozen.

#include <algorithm>
#include <span>

#include "evenstep/time/time.h"

namespace evenstep {

/// The least L in whole ns, without the sampling term. Steps in order, with begins and ends that never decrease; jump >= 0.
/// 0 without steps.
Duration least_latency_with_jump(std::span<const StepTimes> steps, Duration jump);

/// The pause bound: what a map of even slots (its R(n) - R(n-1) = `slot`) needs if step n-1 must read before the length of
/// the pause before step n is known:  max over n of E_n - S_{n-1} - slot. Steps in order. Without the sampling term; at
/// least the longest step.
Duration pause_bound(std::span<const StepTimes> steps, Duration slot);

/// pause_bound with the steps given one at a time.
class PauseBound {
 public:
  explicit PauseBound(Duration slot) : slot_(slot) {}
  void add(RealTime begin, RealTime end) {
    most_ = std::max(most_, end - begin);
    if (any_) most_ = std::max(most_, end - before_ - slot_);
    any_ = true;
    before_ = begin;
  }
  Duration latency() const { return most_; }

 private:
  Duration slot_, most_;
  bool any_ = false;
  RealTime before_;  // the begin of the step before
};

}  // namespace evenstep
