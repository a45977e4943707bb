#include "rate.h"

#include <algorithm>
#include <numeric>

#include "evenstep/harness/trust.h"

namespace evenstep::internal {

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

MapNeeds needs_of(const MapSetup& setup, StrategyKind kind, std::span<const SegmentTiming> segments) {
  const Duration ahead = needed_ahead(setup, kind, setup.emission);
  SegmentNeeds any(setup.grids, setup.emission, RunningNeeds::Phase::any, ahead);
  SegmentNeeds here(setup.grids, setup.emission, RunningNeeds::Phase::this_one, ahead);
  each_mapped_step(setup, kind, segments, [&](std::span<const MappedStep> steps) {
    any.add(steps);
    here.add(steps);
  });
  return {any.take(), here.take()};
}

std::int64_t allowed_underruns(double rate, std::int64_t segments) {
  const auto share = [&](std::int64_t count) { return static_cast<double>(count) / static_cast<double>(segments); };
  auto allowed = static_cast<std::int64_t>(rate * static_cast<double>(segments));
  if (share(allowed + 1) <= rate) ++allowed;  // the product may have been rounded down
  if (share(allowed) > rate) --allowed;
  return allowed;
}

SizeRate rate_of(const MapNeeds& needs, const SizeTrust& trust, double rate, double confidence) {
  const auto least = [&](const std::vector<SegmentNeed>& all, std::int64_t allowed) {
    const RateLatency found = least_latency_with_underruns(all, allowed);
    SizeRateNeed need{found.latency, found.lead, found.underruns, {}};
    if (trust.one_process())
      need.rate_at_most = chosen_rate_at_most(found.underruns, trust.segments, trust.alike, confidence);
    return need;
  };
  SizeRate out;
  out.segments = trust.segments;
  out.allowed = allowed_underruns(rate, trust.segments);
  out.any_phase = least(needs.any_phase, out.allowed);
  out.this_phase = least(needs.this_phase, out.allowed);
  out.segments_needed = chosen_segments_needed(rate, confidence, trust.alike);
  const std::int64_t sure = most_chosen_underruns(rate, confidence, trust.segments, trust.alike);
  if (sure >= 0 && trust.one_process()) out.sure = least(rounded_up(needs.any_phase), sure);
  return out;
}

void NeedPool::add(const SegmentNeed& need) {
  constexpr std::size_t kSlack = 1 << 16;
  needs_.push_back(need);
  if (needs_.size() >= 4 * most_ + kSlack) prune();
}

std::vector<SegmentNeed> NeedPool::take() {
  prune();
  return std::move(needs_);
}

void NeedPool::prune() {
  if (needs_.size() <= 2 * most_) return;
  std::vector<std::size_t> order(needs_.size());
  std::vector<bool> kept(needs_.size());
  const auto keep_most = [&](Duration SegmentNeed::*what) {
    std::iota(order.begin(), order.end(), std::size_t{0});
    const auto before = [&](std::size_t a, std::size_t b) {
      return needs_[a].*what != needs_[b].*what ? needs_[a].*what > needs_[b].*what : a < b;
    };
    const auto end = order.begin() + static_cast<std::ptrdiff_t>(most_);
    std::nth_element(order.begin(), end, order.end(), before);
    std::for_each(order.begin(), end, [&](std::size_t i) { kept[i] = true; });
  };
  keep_most(&SegmentNeed::lead);
  keep_most(&SegmentNeed::delay);
  std::size_t count = 0;
  for (std::size_t i = 0; i < needs_.size(); ++i) {
    if (kept[i]) needs_[count++] = needs_[i];
  }
  needs_.resize(count);
}

}  // namespace evenstep::internal
