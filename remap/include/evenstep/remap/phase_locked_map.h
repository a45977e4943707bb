#pragma once
/// The default map: a second-order phase-locked loop that follows the segment boundaries. Its slots are strictly monotone
/// and, while it is in lock, continuous.
///
///   at boundary (n, B):  e = B - slot(n);  w = min(2 pi BW T^, 0.7)
///                        P += w^2 e / N_prev
///                        slope = clamp(P + sqrt(2) w e / N_prev, (1 - rho) P, (1 + rho) P)      rho = 0.5
///   in between:          slot(n) = phi + (n - n0) slope;  phi <- slot(n) at the next boundary   (continuous)
///
/// P is the estimated time per step, phi the slot of the first step n0 of the segment, BW the bandwidth, T_prev and N_prev
/// the length and step count of the segment that just ended, and T^ = P N_prev. Stable for w < 1.035
/// (4 - 2 sqrt(2) w - w^2 > 0). phi is an integer nanosecond plus a remainder below 1 ns, so the map does not lose
/// precision in a long run. P and phase are first acquired from the first complete segment with steps.
///
/// Out of lock, that is when the slope would have to exceed its clamp (|e| > rho T^ / (sqrt(2) w), 28 ms in the reference
/// case), the phase no longer says anything about the pace, and integrating it would drive P to 0, where the loop has no
/// gain. In that case
///   P <- clamp(T_prev / N_prev, (1 - rho) P, (1 + rho) P);   slope = (1 + rho) P if behind, (1 - rho) P if ahead
/// Only a lag of more than 8 T^ (a hang, which cannot be hidden) is jumped over: phi <- B, slope = P; still monotone.
///
/// A new pace (the visualization time V or the step count N changes; docs/numerics.md, "A change of pace"), with
/// m = T_prev / N_prev as measured:
///   one segment with m more than 20 % off P, and e of the same sign:  the slope is made at least (or at most) m, so that
///     e stays as it is if the pace lasts; after a single long or short segment the next one corrects the whole error
///   two in a row more than 16 % off P and within 6 % of P of each other:  P <- (T + T) / (N + N), phi stays
///   after that, for as long as e shrinks like (1 - sqrt(2) w):  P is left alone (it was just measured; e is only phase)
///
/// Outside its domain: a segment without steps changes nothing (its length becomes part of the next one's error); a period
/// that would fall below 1 ns per step (steps that take no time) is held at 1 ns.

#include <numbers>

#include "evenstep/remap/slot_map.h"

namespace evenstep {

/// The effect of the error e at a boundary: P grows by period * e / N, and the slope becomes P + slope * e / N.
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
  double period_ns() const { return period_ns_; }              ///< P, ns per step; 0 while acquiring
  std::int64_t pace_changes() const { return pace_changes_; }  ///< how often two segments of a new pace replaced P

 protected:
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  RealTime slot_of(std::int64_t n) const;  // only once there are slots
  /// A complete segment, and the P that held when it ended.
  struct Segment {
    double length_ns = 0;
    double steps = 0;  // 0 = none yet
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
  std::int64_t first_step_ = 0;  // n0
  RealTime boundary_;            // B of the current segment
  RealTime origin_;              // integer part of phi
  double remainder_ns_ = 0;      // phi - origin_, in [0, 1)
  double period_ns_ = 0;         // P
  double slope_ns_ = 0;
  Segment last_;
  std::int64_t pace_changes_ = 0;
  double closing_ns_ = 0;  // while only the phase is corrected: e of the boundary before; 0 = loop as usual
};

}  // namespace evenstep
