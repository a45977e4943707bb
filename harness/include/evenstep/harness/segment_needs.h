#pragma once
/// What each segment of a schedule needs of a map: segment k has no underrun at lead c and latency L if c >= a_k and
/// L - c >= b_k. a_k is the lead that its reads need, b_k the largest E - slot of its forces (remap/latency_budget.h).

#include <cstdint>
#include <span>
#include <vector>

#include "evenstep/remap/latency_budget.h"
#include "evenstep/time/time.h"

namespace evenstep::internal {

struct SegmentNeed {
  Duration lead;        ///< a_k
  Duration delay;       ///< b_k
  RealTime begin = {};  ///< of its first mapped step
};

/// Collects the needs of the segments from mapped steps in order.
class SegmentNeeds {
 public:
  /// `ahead` is added to each delay: what the strategy needs beyond its map (harness/sizing.h).
  SegmentNeeds(std::span<const SamplingGrid> devices, Emission emission, RunningNeeds::Phase phase, Duration ahead)
      : running_(devices, emission, phase), ahead_(ahead) {}
  void add(std::span<const MappedStep> steps);
  /// Call once after the last step. Returns one entry per segment with a mapped step.
  std::vector<SegmentNeed> take();

 private:
  void end_segment();

  RunningNeeds running_;
  Duration ahead_;
  std::vector<SegmentNeed> needs_;
  std::int64_t segment_ = -1;
  RealTime begin_;
};

}  // namespace evenstep::internal
