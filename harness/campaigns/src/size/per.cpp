#include "per.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "evenstep/campaigns/size.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/trust.h"
#include "tail.h"

namespace evenstep::internal {
namespace {

/// Needs of one kind on the way from the median to the largest.
struct Way {
  Duration median, largest;
  Way(std::span<const SegmentNeed> needs, Duration SegmentNeed::*what) {
    std::vector<Duration> all;
    for (const SegmentNeed& need : needs) all.push_back(need.*what);
    const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
    std::nth_element(all.begin(), middle, all.end());
    median = *middle;
    largest = *std::max_element(all.begin(), all.end());
  }
  double of(Duration need) const {
    const auto length = static_cast<double>((largest - median).ns);
    return length > 0 ? static_cast<double>((need - median).ns) / length : -1;
  }
  Duration at(double x) const {
    return median + Duration{static_cast<std::int64_t>(std::ceil(x * static_cast<double>((largest - median).ns)))};
  }
};

}  // namespace

SizePer size_per(std::span<const SegmentNeed> needs, const SizeTrust& trust, Duration span, double rate, double confidence) {
  SizePer out;
  const double segment =
      needs.size() < 2 ? 0 : seconds(needs.back().begin - needs.front().begin) / static_cast<double>(trust.segments - 1);
  const double in_span = segment > 0 ? seconds(span) / segment : 0;
  out.rate = in_span > 1 ? std::max(std::floor(rate * in_span), 1.0) / in_span : 1;
  const auto refuse = [&](const char* why, double segments) {
    out.refused = why;
    const double more = std::ceil(std::max(segments - static_cast<double>(trust.segments), 0.0) * segment);
    out.to_record = {static_cast<std::int64_t>(more) * 1'000'000'000};
    return out;
  };
  if (out.rate >= 1) return refuse("the span is not longer than a segment", 0);
  if (!trust.one_process()) return refuse("it is not one process", 0);
  if (const std::int64_t late = most_chosen_underruns(out.rate, confidence, trust.segments, trust.alike); late >= 0) {
    const RateLatency found = least_latency_with_underruns(rounded_up(needs), late);
    out.latency = out.likely_latency = found.latency;
    out.lead = found.lead;
    return out;
  }
  if (trust.effective() < kLeastForTail) return refuse("too short for a tail", kLeastForTail * trust.alike);
  const Way leads(needs, &SegmentNeed::lead), delays(needs, &SegmentNeed::delay);
  std::vector<double> way;
  for (const SegmentNeed& need : needs) way.push_back(std::max(leads.of(need.lead), delays.of(need.delay)));
  const auto seen_enough = static_cast<double>(chosen_segments_needed(out.rate, confidence, trust.alike));
  const std::optional<Tail> tail = tail_of(way, out.rate, confidence);
  if (!tail) return refuse("no one tail fits its longest", seen_enough);
  out.exceedances = tail->exceedances;
  out.shape = tail->shape;
  out.shape_at_most = tail->shape_at_most;
  if (tail->shape_at_most >= kHeaviest) return refuse("its tail is too heavy", seen_enough);
  out.beyond = true;
  out.lead = leads.at(tail->at_most);
  out.latency = out.lead + delays.at(tail->at_most);
  out.likely_latency = leads.at(tail->estimate) + delays.at(tail->estimate);
  return out;
}

}  // namespace evenstep::internal

namespace evenstep {

std::optional<TrustedLatency> trusted_latency(const Scenario& scenario, StrategyKind kind) {
  const bool unknown = scenario.timing.real_steps || scenario.remap.interaction_underrun == InteractionUnderrun::gate;
  if (!is_remap(kind) || unknown) return std::nullopt;
  const MapSetup setup = map_setup(scenario);
  internal::SegmentNeeds collected(setup.grids, setup.emission, RunningNeeds::Phase::any,
                                   needed_ahead(setup, kind, setup.emission));
  each_run_step(setup, scenario.timing, kind, Duration{}, [&](std::span<const MappedStep> steps) { collected.add(steps); });
  const std::vector<internal::SegmentNeed> needs = collected.take();
  if (needs.empty()) return std::nullopt;
  TrustedLatency out{internal::trust_in(needs), {}};
  if (scenario.timing.trace.empty() && !scenario.timing.elsewhere && is_periodic(scenario.timing.programmed)) {
    const internal::RateLatency all = internal::least_latency_with_underruns(needs, 0);
    out.per.latency = out.per.likely_latency = all.latency;
    out.per.lead = all.lead;
  } else {
    out.per = internal::size_per(needs, out.trust, TrustedLatency::kSpan, 0, TrustedLatency::kConfidence);
  }
  return out;
}

}  // namespace evenstep
