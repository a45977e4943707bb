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

/// The pauses bound: what any map needs, however it works, that knows the past only and changes its velocity by at most
/// `jump` ns a step, if after any step the next ones may come evenly, one `slot` after the other. Where pauses come so close
/// to each other that it is still late from the one when the next begins, it is more than the pause bound:
///     L >= E_{n+k} - S_n - k slot - jump k (k + 1)   for all n and k >= 0
/// because such a map must not be ahead when even steps follow. Going u faster than a slot a step at step n, it comes
/// max over i of (i u - jump i (i + 1) / 2) ahead while it brakes, so R(n) is at most S_n less that; then
/// R(n+k) <= R(n) + k (slot + u) + jump k (k + 1) / 2 is the largest for u = k jump. Steps in order, jump >= 0; without the
/// sampling term.
Duration pauses_bound(std::span<const StepTimes> steps, Duration slot, Duration jump);

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
