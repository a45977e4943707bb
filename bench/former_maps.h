#pragma once
/// Maps to compare the default one with (bench/map_fronts.cpp); the product does not have them. Both learn only at
/// boundaries: they acquire phi and P from the first complete segment, and then, when segment k ends with N steps at B,
///
///   e = B - slot(n);   w = min(2 pi BW T^, 0.7);   T^ = P N        BW the bandwidth; n the first step of the next segment
///   slot(n + i) = slot(n) + i slope in the next segment             continuous
///
/// and choose P and the slope from e. The lead is 0. A segment without steps changes nothing.

#include "evenstep/remap/slot_map.h"

namespace evenstep::bench {

class BoundaryLoop : public SlotMap {
 public:
  explicit BoundaryLoop(double bandwidth_Hz) : SlotMap({}, Duration{}), bandwidth_Hz_(bandwidth_Hz) {}
  void boundary(std::int64_t n, RealTime begin) final;

 protected:
  std::optional<RealTime> slot(std::int64_t n) final;
  double gain(double steps) const;  // w after a segment of so many steps

  RealTime origin_;          // integer part of phi, the slot of the first step of the segment
  double remainder_ns_ = 0;  // phi - origin_, in [0, 1)
  double period_ns_ = 0;     // P, time per step; 0 while acquiring
  double slope_ns_ = 0;      // from slot to slot

 private:
  /// Chooses P and the slope; phi is already the slot that the next segment begins with.
  virtual void track(RealTime begin, double error_ns, double length_ns, double steps) = 0;
  void acquire(RealTime begin, double length_ns, double steps);
  void advance(double steps);

  double bandwidth_Hz_;
  bool started_ = false;
  std::int64_t first_step_ = 0;
  RealTime boundary_;
};

/// The second-order loop alone. With b = sqrt(2) w and c = w^2:
///   jack:          slope = P + b e / N;  P += c e / N    the delay-locked loop of F. Adriaensen, "Using a DLL to filter
///                  time" (2005), which JACK uses: t0 = t1; t1 += b e + e2; e2 += c e, with e2 = P N. There every segment
///                  has as many steps as the last; here e is that of the steps it had.
///   period_first:  P += c e / N;  slope = P + b e / N    the loop within FormerMap
/// Neither bounds the slope, which may be negative; P is at least 1 ns.
class SecondOrderLoop final : public BoundaryLoop {
 public:
  enum class Order { jack, period_first };
  SecondOrderLoop(double bandwidth_Hz, Order order) : BoundaryLoop(bandwidth_Hz), order_(order) {}

 private:
  void track(RealTime begin, double error_ns, double length_ns, double steps) override;
  Order order_;
};

/// The default map before it looked at single steps: the loop above (period_first) with its slope within 0.5 P and 1.5 P,
/// and with rules for what is not jitter. With m = T / N of the segment that ended:
///   out of lock, |sqrt(2) w e / N| > P / 2:  P <- m within 0.5 P and 1.5 P; slope = 1.5 P if behind, 0.5 P if ahead; a lag
///     of more than 8 T^ is jumped over
///   m more than 20 % off P, and e of the same sign:  the slope is at least (or at most) m
///   two segments in a row more than 16 % off P and within 6 % of P of each other:  P <- their mean
///   after that, for as long as e shrinks like (1 - w / sqrt(2)):  P is left alone
class FormerMap final : public BoundaryLoop {
 public:
  explicit FormerMap(double bandwidth_Hz) : BoundaryLoop(bandwidth_Hz) {}

 private:
  /// A complete segment, and the P that held when it ended.
  struct Segment {
    double length_ns = 0;
    double steps = 0;  // 0 = none yet
    double period_ns = 0;
  };
  void track(RealTime begin, double error_ns, double length_ns, double steps) override;
  bool pace_moved(const Segment& before, double measured_ns) const;
  bool closing(double error_ns, double w) const;
  void relock(RealTime begin, double error_ns, double measured_ns, double steps);

  Segment last_;
  double closing_ns_ = 0;  // while only the phase is corrected: e of the boundary before; 0 = loop as usual
};

}  // namespace evenstep::bench
