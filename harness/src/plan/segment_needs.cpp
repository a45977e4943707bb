#include "evenstep/harness/segment_needs.h"

#include <utility>

namespace evenstep::internal {

void SegmentNeeds::add(std::span<const MappedStep> steps) {
  std::size_t from = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].segment == segment_) continue;
    running_.add(steps.subspan(from, i - from));
    end_segment();
    segment_ = steps[i].segment;
    begin_ = steps[i].begin;
    from = i;
  }
  running_.add(steps.subspan(from));
}

void SegmentNeeds::end_segment() {
  const LatencyBudget budget = running_.budget();
  if (budget.latency_culprit >= 0) needs_.push_back({budget.lead, budget.latency - budget.lead + ahead_, begin_});
  running_.restart_needs();
}

std::vector<SegmentNeed> SegmentNeeds::take() {
  end_segment();
  return std::move(needs_);
}

}  // namespace evenstep::internal
