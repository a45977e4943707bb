#pragma once
/// The paper's map as published: slot(n) = B_k + (n - n_k) T^ / N^, where B_k is the measured begin of segment k, n_k its
/// first step, T^ the weighted average of the segment lengths and N^ the expected step count. The paper says that T^ is a
/// weighted average, and not where N^ comes from: it assumes a cycle, in which N is always the same. Where N varies, T^ / N^
/// is the pace if N^ is the average of N in the weights of T^ (the default). If N^ is the last segment's N, which belongs to
/// another T than T^, the pace jumps. At each boundary the map jumps by exactly T_k - T^_k N_k / N^; if that is below -tau,
/// slots run backwards (docs/choose/numerics.md).
/// The first complete segment with steps gives the first T^ and N^. Outside its domain: a segment without steps sets a new
/// B_k but leaves T^ and N^ as they were; slots past N^ continue at the same pace.

#include "evenstep/remap/segment_estimator.h"
#include "evenstep/remap/slot_map.h"

namespace evenstep {

enum class StepCount : std::uint8_t { average, last };

class PaperMap final : public SlotMap {
 public:
  PaperMap(Duration lead, const AdaptiveLatency& latency, double weight, StepCount count = StepCount::average)
      : SlotMap(lead, latency), estimator_(weight), count_weight_(count == StepCount::last ? 1 : weight) {}
  void boundary(std::int64_t n, RealTime begin) override;

 protected:
  std::optional<RealTime> slot(std::int64_t n) override;

 private:
  SegmentEstimator estimator_;
  bool started_ = false;
  std::int64_t first_step_ = 0;  // n_k
  RealTime begin_;               // B_k
  double count_weight_;
  double step_count_ = 0;  // N^; 0 = none yet
};

}  // namespace evenstep
