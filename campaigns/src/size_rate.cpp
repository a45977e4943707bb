#include "size_rate.h"

#include <algorithm>
#include <numeric>

#include "evenstep/reports/rate_bound.h"

namespace evenstep::internal {

void SegmentNeeds::add(std::span<const MappedStep> steps) {
  std::size_t from = 0;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].segment == segment_) continue;
    running_.add(steps.subspan(from, i - from));
    end_segment();
    segment_ = steps[i].segment;
    from = i;
  }
  running_.add(steps.subspan(from));
}

void SegmentNeeds::end_segment() {
  const LatencyBudget budget = running_.budget();
  if (budget.latency_culprit >= 0) needs_.push_back({budget.lead, budget.latency - budget.lead});
  running_.restart_needs();
}

std::vector<SegmentNeed> SegmentNeeds::take() {
  end_segment();
  return std::move(needs_);
}

RateLatency least_latency_with_underruns(std::span<const SegmentNeed> needs, std::int64_t allowed) {
  std::vector<std::size_t> by_lead(needs.size()), by_delay(needs.size());
  std::iota(by_lead.begin(), by_lead.end(), std::size_t{0});
  by_delay = by_lead;
  std::stable_sort(by_lead.begin(), by_lead.end(),
                   [&](std::size_t a, std::size_t b) { return needs[a].lead > needs[b].lead; });
  std::stable_sort(by_delay.begin(), by_delay.end(),
                   [&](std::size_t a, std::size_t b) { return needs[a].delay > needs[b].delay; });
  std::vector<std::size_t> rank(needs.size());
  for (std::size_t r = 0; r < by_delay.size(); ++r) rank[by_delay[r]] = r;

  std::vector<bool> given_up(needs.size());
  auto deciding = static_cast<std::size_t>(allowed);  // position in by_delay of the force that must not be late
  RateLatency least;
  for (std::size_t i = 0; i <= static_cast<std::size_t>(allowed); ++i) {
    const Duration lead = needs[by_lead[i]].lead, delay = needs[by_delay[deciding]].delay;
    if (i == 0 || lead + delay < least.latency) least = {lead, lead + delay, 0};
    // One more segment may have underruns in its reads, so one fewer in its forces. If the force of that segment is not
    // among those before the deciding one, the next larger of the others decides.
    given_up[by_lead[i]] = true;
    if (rank[by_lead[i]] < deciding || i == static_cast<std::size_t>(allowed)) continue;
    do --deciding;
    while (given_up[by_delay[deciding]]);
  }
  for (const SegmentNeed& need : needs)
    least.underruns += need.lead > least.lead || need.delay > least.latency - least.lead ? 1 : 0;
  return least;
}

std::int64_t most_underruns_for(double rate, double confidence, std::int64_t segments) {
  std::int64_t fine = -1, too_many = segments;  // the bound grows with the underruns, and is 1 where all have one
  while (too_many - fine > 1) {
    const std::int64_t middle = fine + (too_many - fine) / 2;
    (rate_at_most(middle, segments, confidence) <= rate ? fine : too_many) = middle;
  }
  return fine;
}

}  // namespace evenstep::internal
