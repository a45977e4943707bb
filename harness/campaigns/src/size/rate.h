#pragma once
/// The exact least latency for a given rate of underruns, over the segments of one timing.
///
/// Segment k has no underrun at lead c and latency L if  c >= a_k  and  L - c >= b_k:  a_k the lead that its reads need, b_k
/// the largest E - slot of its forces (remap/latency_budget.h). At most m segments with an underrun:
///   L = min over c of [c + the (m - i + 1)-th largest b_k of those with a_k <= c],   i the number of those with a_k > c.
/// Only the m + 1 largest a_k are candidates for c. As c goes down through them, the deciding b_k only goes up.
/// O(n log n).

#include <cstdint>
#include <span>
#include <vector>

#include "evenstep/harness/segment_needs.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/size_record.h"

namespace evenstep::internal {

struct RateLatency {
  Duration lead, latency;
  std::int64_t underruns = 0;  ///< number of segments with an underrun
};
/// 0 <= allowed < needs.size(). Among equal latencies it is the one with the largest lead.
RateLatency least_latency_with_underruns(std::span<const SegmentNeed> needs, std::int64_t allowed);

/// The segments of a scenario's timing that begin within its run.
std::vector<SegmentTiming> segments_of(const Scenario& scenario);
/// Those that can be sized; `other_maps`: also those that are there for comparison only.
std::vector<StrategyKind> maps_to_size(const MapSetup& setup, bool other_maps);

/// The needs of one map over the segments of a run, at any phase of its devices and at the scenario's.
struct MapNeeds {
  std::vector<SegmentNeed> any_phase, this_phase;  ///< one per segment with a mapped step
};
MapNeeds needs_of(const MapSetup& setup, StrategyKind kind, std::span<const SegmentTiming> segments);

/// floor(rate * segments), without the error of the product.
std::int64_t allowed_underruns(double rate, std::int64_t segments);
/// The latencies for that rate. The needs may be those of a pool; `trust` is in all segments.
SizeRate rate_of(const MapNeeds& needs, const SizeTrust& trust, double rate, double confidence);

/// Of many segments those that decide, when `allowed` of them may have an underrun: the allowed + 1 largest leads, and the
/// allowed + 1 largest delays. The formula above looks at no others. So its memory is that of the underruns allowed, not of
/// the segments.
class NeedPool {
 public:
  explicit NeedPool(std::int64_t allowed) : most_(static_cast<std::size_t>(allowed) + 1) {}
  void add(const SegmentNeed& need);
  /// In the order in which they were added.
  std::vector<SegmentNeed> take();

 private:
  void prune();

  std::size_t most_;
  std::vector<SegmentNeed> needs_;
};

}  // namespace evenstep::internal
