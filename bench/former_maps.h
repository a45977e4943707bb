#pragma once
/// Maps to compare the default one with (bench/map_fronts.cpp); the product does not have them. All learn only at
/// boundaries: they acquire phi and P from the first complete segment, and then, when a segment of length T with N steps
/// ends at B,
///
///   e = B - slot(n)                              n is the first step of the next segment
///   slot(n + i) = slot(n) + i slope              in the next segment: the slots are continuous
///
/// and choose P (time per step) and the slope from e. The lead is 0. A segment without steps changes nothing. They differ in
/// w, which is 2 pi BW T^ (BW the bandwidth, T^ their idea of T) but at most 0.7, and in what they do with it.

#include "evenstep/remap/slot_map.h"

namespace evenstep::bench {

class BoundaryLoop : public SlotMap {
 public:
  BoundaryLoop() : SlotMap({}, Duration{}) {}
  void boundary(std::int64_t n, RealTime begin) final;

 protected:
  std::optional<RealTime> slot(std::int64_t n) final;

  RealTime origin_;          // integer part of phi, the slot of the first step of the segment
  double remainder_ns_ = 0;  // phi - origin_, in [0, 1)
  double period_ns_ = 0;     // P
  double slope_ns_ = 0;      // the time from slot to slot

 private:
  /// Chooses P and the slope. phi is already the first slot of the next segment.
  virtual void track(RealTime begin, double error_ns, double length_ns, double steps) = 0;
  void advance(double steps);

  bool started_ = false, acquired_ = false;
  std::int64_t first_step_ = 0;
  RealTime boundary_;
};

/// The delay-locked loop of F. Adriaensen, "Using a DLL to filter time" (Linux Audio Conference 2005), which JACK uses:
///   t0 = t1;   t1 += b e + e2;   e2 += c e         b = sqrt(2) w, c = w^2, e2 = P N
/// T^ is a constant that it is given. With it every segment has as many steps as the one before; here the steps are
/// counted:  slope = P + b e / N;  P += c e / N. Nothing is bounded: slots may step back.
class DelayLockedLoop final : public BoundaryLoop {
 public:
  DelayLockedLoop(double bandwidth_Hz, Duration segment);

 private:
  void track(RealTime begin, double error_ns, double length_ns, double steps) override;
  double w_;
};

/// The same loop with T^ = P N, and with P updated first (and at least 1 ns):  P += c e / N;  slope = P + b e / N. This is
/// FormerMap without its rules.
class BareLoop final : public BoundaryLoop {
 public:
  explicit BareLoop(double bandwidth_Hz) : bandwidth_Hz_(bandwidth_Hz) {}

 private:
  void track(RealTime begin, double error_ns, double length_ns, double steps) override;
  double bandwidth_Hz_;
};

/// The default map as it was before it looked at single steps: the loop above, with its slope between 0.5 P and 1.5 P, and
/// with rules for what is not jitter. With m = T / N:
///   out of lock, |sqrt(2) w e / N| > P / 2:  P <- m within 0.5 P and 1.5 P; slope = 1.5 P if behind, 0.5 P if ahead; a lag
///     of more than 8 T^ is jumped over
///   m more than 20 % off P, and e of the same sign:  the slope is at least (or at most) m
///   two segments in a row more than 16 % off P and within 6 % of P of each other:  P <- their mean
///   after that, for as long as e shrinks like (1 - w / sqrt(2)):  P is left alone
class FormerMap final : public BoundaryLoop {
 public:
  explicit FormerMap(double bandwidth_Hz) : bandwidth_Hz_(bandwidth_Hz) {}

 private:
  /// A complete segment, and the P that was in use when it ended.
  struct Segment {
    double length_ns = 0;
    double steps = 0;  // 0: no segment yet
    double period_ns = 0;
  };
  void track(RealTime begin, double error_ns, double length_ns, double steps) override;
  bool pace_moved(const Segment& before, double measured_ns) const;
  bool closing(double error_ns, double w) const;
  void relock(RealTime begin, double error_ns, double measured_ns, double steps);

  double bandwidth_Hz_;
  Segment last_;
  double closing_ns_ = 0;  // while only the phase is corrected: e of the boundary before; 0 = loop as usual
};

}  // namespace evenstep::bench
