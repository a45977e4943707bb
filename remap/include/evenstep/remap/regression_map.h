#pragma once
/// The line by which the Lab Streaming Layer takes the jitter out of time stamps (liblsl, option "dejitter"), as a slot map:
/// for comparison with `phase_locked`, not for use. Recursive least squares with forgetting (S. Haykin, "Adaptive Filter
/// Theory", 4th edition, table 9.1) of the begins S of the steps on their numbers:
///
///   at the first step:      y = S (the line at this step), v = 0 (its slope), P = 1e10 I
///   at every later one:     y = y + v, P = F P F' with F = (1 1; 0 1)      the line and P as seen from this step
///   at each of them:        k = (P00, P01) / (l + P00);  e = S - y;  (y, v) = (y, v) + k e;  P = (P - k (P00, P01)) / l
///   slot = y, and not before the slot of the step before (liblsl: "monotonize")
///
/// l = 1 - f / r forgets at the rate f (liblsl forgets a half in 90 s, which is f = 0.0077 Hz) at the nominal step rate r.
/// Counting steps from the present one, and not from the first as liblsl does, is the same line with less rounding.
///
/// The line knows no segments. So that all maps are judged from the same step on, it has no slots before the second
/// boundary. Outside the formula: l is at least 0.5.

#include "evenstep/remap/slot_map.h"

namespace evenstep {

class RegressionMap final : public SlotMap {
 public:
  RegressionMap(Rate step_rate, Duration lead, const AdaptiveLatency& latency, double forgetting_Hz = 0.0077);
  void boundary(std::int64_t n, RealTime begin) override;

 protected:
  void began(std::int64_t n, RealTime begin) override;
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  double keep_;                               // l
  bool started_ = false, complete_ = false;   // a step, a whole segment has been seen
  std::int64_t first_step_ = -1;              // of the segment
  RealTime origin_, last_slot_;               // y floored to ns; the newest slot
  double remainder_ns_ = 0, slope_ns_ = 0;    // y - origin_, v
  double p00_ = 1e10, p01_ = 0, p11_ = 1e10;  // P
};

}  // namespace evenstep
