#pragma once
/// The delay-locked loop by which JACK maps audio frames to time, as a slot map: for comparison with `phase_locked`, not for
/// use. F. Adriaensen, "Using a DLL to filter time" (Linux Audio Conference 2005), with JACK's period as the segment:
///
///   after the first complete segment:  t0 = B, e2 = T, t1 = B + e2
///   at each boundary B after it:       e = B - t1;  t0 = t1;  t1 = t1 + b e + e2;  e2 = e2 + c e
///   slot of step i of the segment:     t0 + i (t1 - t0) / N
///   with w = 2 pi f T of that first segment, b = sqrt(2) w, c = w^2, and f the bandwidth (JACK 2 has 0.125 Hz)
///
/// Here N is the step count of the segment before. If the segment then has another number of steps, t1 is the slot of the
/// step after its last one, and e2 is scaled to the new N.
///
/// Outside the formula: w is at most 0.5, because the loop rings at more; t1 - t0 is at least 1 ns per step, so the slots
/// are strictly monotone. An e2 beyond 1000 s per step is held there. A segment without steps becomes part of the next one.
/// JACK itself also begins anew, with t0 = B, after an xrun; the published loop does not, and neither does this one.

#include "evenstep/remap/slot_map.h"

namespace evenstep {

class DelayLockedMap final : public SlotMap {
 public:
  DelayLockedMap(Duration lead, const AdaptiveLatency& latency, double bandwidth_Hz = 0.125)
      : SlotMap(lead, latency), bandwidth_Hz_(bandwidth_Hz) {}
  void boundary(std::int64_t n, RealTime begin) override;

 protected:
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  double bandwidth_Hz_;
  bool started_ = false;
  std::int64_t first_step_ = 0;  // of the segment
  RealTime origin_;              // t0, floored to ns
  double remainder_ns_ = 0;      // t0 - origin_
  double turn_ = 0;              // w
  double slot_ns_ = 0;           // (t1 - t0) / N; 0 while acquiring
  double period_ns_ = 0;         // e2 / N
};

}  // namespace evenstep
