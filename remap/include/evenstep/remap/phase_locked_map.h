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
/// Outside its domain: a segment without steps changes nothing (its length goes into the next one's error); a period that
/// would fall below 1 ns per step (steps in zero time) is held there.

#include "evenstep/remap/slot_map.h"

namespace evenstep {

class PhaseLockedMap final : public SlotMap {
 public:
  PhaseLockedMap(Duration lead, Duration latency, double bandwidth_Hz = 2.0)
      : SlotMap(lead, latency), bandwidth_Hz_(bandwidth_Hz) {}
  void boundary(std::int64_t n, RealTime begin) override;
  double period_ns() const { return period_ns_; }   ///< P, ns per step; 0 while acquiring

 protected:
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  void acquire(RealTime begin, double length_ns, double steps);
  void track(RealTime begin, double length_ns, double steps);
  void relock(RealTime begin, double error_ns, double length_ns, double steps);

  double bandwidth_Hz_;
  bool started_ = false;
  std::int64_t first_step_ = 0;      // n0
  RealTime boundary_;                // B of the running segment
  RealTime origin_;                  // integer part of phi
  double remainder_ns_ = 0;          // phi - origin_, in [0, 1)
  double period_ns_ = 0;             // P
  double slope_ns_ = 0;
};

}  // namespace evenstep
