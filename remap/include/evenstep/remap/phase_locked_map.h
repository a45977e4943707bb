#pragma once
/// The default map: strictly monotone and, in lock, continuous; a second-order loop locked to the segment boundaries.
///
///   at boundary (n, B):  e = B - slot(n);  w = min(2 pi BW T^, 0.7)
///                        P += w^2 e / N_prev
///                        slope = clamp(P + sqrt(2) w e / N_prev, (1 - rho) P, (1 + rho) P)      rho = 0.5
///   in between:          slot(n) = phi + (n - n0) slope;  phi <- slot(n) at the next boundary   (continuous)
///
/// T^ = P N_prev. Stable for w < 1.035 (4 - 2 sqrt(2) w - w^2 > 0). phi is an integer nanosecond plus a remainder below
/// 1 ns, so the map does not lose precision in a long run. Acquires P and phase from the first complete segment with
/// steps.
///
/// Out of lock (the slope would need more than its clamp: |e| > rho T^ / (sqrt(2) w), 28 ms in the reference case) the
/// phase says nothing about the pace any more, and integrating it would drive P to 0, where the loop has no gain. Then
///   P <- clamp(T_prev / N_prev, (1 - rho) P, (1 + rho) P);   slope = (1 + rho) P if behind, (1 - rho) P if ahead
/// and only a lag of more than 8 T^ (a hang, which cannot be hidden) steps forward: phi <- B, slope = P; still monotone.
///
/// A new pace (V or N steps up or down; docs/numerics.md, "A change of pace"), with m = T_prev / N_prev measured:
///   one segment with m more than 20 % off P, and e of the same sign:  slope at least (or at most) m, so that e stays if
///     the pace stays; if it was a single long or short segment, its whole error is made good in the next
///   two in a row more than 16 % off P and within 6 % of P of each other:  P <- (T + T) / (N + N), phi stays
///   and until e has stopped shrinking like (1 - sqrt(2) w): P is left alone (it was just measured; e is phase only)
///
/// Outside its domain: a segment without steps changes nothing (its length goes into the next one's error); a period that
/// would fall below 1 ns per step (steps in zero time) is held there.

#include <numbers>

#include "evenstep/remap/slot_map.h"

namespace evenstep {

/// What the error e at a boundary does: P grows by period * e / N, and the slope is P + slope * e / N.
struct LoopGains {
  double period = 0;
  double slope = 0;
};
constexpr LoopGains loop_gains(double w) { return {w * w, std::numbers::sqrt2 * w}; }

class PhaseLockedMap final : public SlotMap {
 public:
  PhaseLockedMap(Duration lead, const AdaptiveLatency& latency, double bandwidth_Hz = 2.0)
      : SlotMap(lead, latency), bandwidth_Hz_(bandwidth_Hz) {}
  void boundary(std::int64_t n, RealTime begin) override;
  bool slots(std::int64_t n, std::span<RealTime> out) override;
  double period_ns() const { return period_ns_; }   ///< P, ns per step; 0 while acquiring
  std::int64_t pace_changes() const { return pace_changes_; }   ///< how often P was taken from two segments anew

 protected:
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  RealTime slot_of(std::int64_t n) const;   // where there are slots
  /// A complete segment, and P as it was when the segment ended.
  struct Segment {
    double length_ns = 0;
    double steps = 0;   // 0 = none yet
    double period_ns = 0;
  };
  void acquire(RealTime begin, double length_ns, double steps);
  void track(RealTime begin, double length_ns, double steps);
  void advance(double steps);
  bool pace_moved(const Segment& before, double measured_ns) const;
  bool closing(double error_ns, double w) const;
  void relock(RealTime begin, double error_ns, double measured_ns, double steps);

  double bandwidth_Hz_;
  bool started_ = false;
  std::int64_t first_step_ = 0;      // n0
  RealTime boundary_;                // B of the running segment
  RealTime origin_;                  // integer part of phi
  double remainder_ns_ = 0;          // phi - origin_, in [0, 1)
  double period_ns_ = 0;             // P
  double slope_ns_ = 0;
  Segment last_;
  std::int64_t pace_changes_ = 0;
  double closing_ns_ = 0;            // e of the boundary before while only the phase is being closed; 0 = loop as usual
};

}  // namespace evenstep
