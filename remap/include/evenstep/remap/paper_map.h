#pragma once
/// The paper's map as published: slot(n) = B_k + (n - n_k) T^ / N^, where B_k is the measured begin of segment k, n_k its
/// first step, T^ the weighted average of the segment lengths and N^ the step count of the previous segment. At each
/// boundary it jumps by exactly T_k - T^_k; if that is below -tau, slots run backwards (docs/numerics.md).
/// The first complete segment with steps gives the first T^ and N^. Outside its domain: a segment without steps sets a new
/// B_k but leaves T^ and N^ as they were; slots past N^ continue at the same pace.

#include "evenstep/remap/segment_estimator.h"
#include "evenstep/remap/slot_map.h"

namespace evenstep {

class PaperMap final : public SlotMap {
 public:
  PaperMap(Duration lead, const AdaptiveLatency& latency, double weight) : SlotMap(lead, latency), estimator_(weight) {}
  void boundary(std::int64_t n, RealTime begin) override;

 protected:
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  SegmentEstimator estimator_;
  bool started_ = false;
  std::int64_t first_step_ = 0;  // n_k
  RealTime begin_;               // B_k
  std::int64_t step_count_ = 0;  // N^; 0 = none yet
};

}  // namespace evenstep
