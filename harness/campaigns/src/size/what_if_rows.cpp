#include "what_if_rows.h"

#include <algorithm>

#include "evenstep/remap/jump_bound.h"
#include "evenstep/remap/velocity_jump.h"
#include "rate.h"

namespace evenstep::internal {
namespace {

/// First and last begin of a step, the last end, and how many there are.
struct Extent {
  RealTime first, last, end;
  std::int64_t steps = 0;

  explicit Extent(std::span<const SegmentTiming> segments) {
    for (const SegmentTiming& segment : segments) {
      for (const Interval& step : segment.steps) {
        if (steps++ == 0) first = step.begin;
        last = step.begin;
        end = std::max(end, step.end);
      }
    }
  }
  Duration slot() const { return {steps > 1 ? (last - first).ns / (steps - 1) : 0}; }
};

class Rows {
 public:
  Rows(const MapSetup& setup, std::span<const StrategyKind> maps, const SizeOptions& options)
      : setup_(setup), maps_(maps), options_(options) {
    for (const SamplingGrid& grid : setup.grids) period_ = std::max(period_, period_ceil(grid.rate) + grid.age);
  }

  SizeWhatIf row(const WhatIf& what_if, std::span<const SegmentTiming> segments, bool causally) {
    SizeWhatIf out{.text = text_of(what_if), .causal = causally};
    const Result<WhatIfTiming> changed = apply(what_if, segments, causally);
    if (!changed) {
      out.refused = changed.error();
      return out;
    }
    const DrawingPrice& price = changed->price;
    out.pace = changed->pace;
    out.drawings = price.drawings;
    out.left_out = price.left_out;
    out.over_budget = price.over_budget;
    out.drawings_per_s = price.drawings_per_s;
    out.longest_pause = price.longest_drawing_pause;
    out.longest_without = price.longest_without_drawing;
    out.simulated_against_real = price.simulated_against_real;
    out.segments_lost = price.segments_lost;
    const Extent extent(changed->segments);
    setup_.end = extent.end + Duration{1};
    // A recording is spread from its second segment on.
    const bool learns = what_if.spread && !what_if.own_lane && segments.size() > 1;
    out.pause_bound = pause_bound(changed->segments, extent, learns ? segments[1].begin : extent.first);
    for (const StrategyKind map : maps_) out.maps.push_back(map_row(map, changed->segments, extent));
    return out;
  }

 private:
  /// Of the steps that begin at or after `from`.
  Duration pause_bound(std::span<const SegmentTiming> segments, const Extent& extent, RealTime from) const {
    PauseBound bound(extent.slot());
    std::optional<Interval> before;
    const bool linear = setup_.emission == Emission::linear;
    for (const SegmentTiming& segment : segments) {
      for (const Interval& step : segment.steps) {
        if (step.begin < from) continue;
        if (!linear) bound.add(step.begin, step.end);
        if (linear && before) bound.add(before->begin, step.end);
        before = step;
      }
    }
    return bound.latency() + period_ - Duration{1};
  }

  SizeWhatIf::Map map_row(StrategyKind kind, std::span<const SegmentTiming> segments, const Extent& extent) const {
    RunningNeeds any(setup_.grids, setup_.emission, RunningNeeds::Phase::any);
    SegmentNeeds rates(setup_.grids, setup_.emission, RunningNeeds::Phase::any, {});
    VelocityJump jump(extent.first + std::min(Duration{1'000'000'000}, Duration{(extent.end - extent.first).ns / 2}));
    each_mapped_step(setup_, kind, segments, [&](std::span<const MappedStep> steps) {
      any.add(steps);
      jump.add(steps);
      if (options_.rate) rates.add(steps);
    });
    const LatencyBudget least = any.budget();
    SizeWhatIf::Map out{.name = name_of(kind), .latency = least.latency};
    out.jump_seen = jump.seen();
    if (const Duration slot = extent.slot(); slot.ns > 0)
      out.velocity_jump = static_cast<double>(jump.most_ns()) / static_cast<double>(slot.ns);
    if (options_.rate) put_rate(rates.take(), out);
    if (options_.adaptive) put_adaptive(kind, segments, least, out);
    return out;
  }

  void put_rate(const std::vector<SegmentNeed>& needs, SizeWhatIf::Map& out) const {
    if (needs.empty()) return;
    const auto segments = static_cast<double>(needs.size());
    auto allowed = static_cast<std::int64_t>(*options_.rate * segments);
    if (static_cast<double>(allowed) / segments > *options_.rate) --allowed;  // the product may have been rounded up
    out.rate_latency = least_latency_with_underruns(needs, std::max<std::int64_t>(allowed, 0)).latency;
  }

  /// Starts with the least fixed latency, which is also the most.
  void put_adaptive(StrategyKind kind, std::span<const SegmentTiming> segments, const LatencyBudget& least,
                    SizeWhatIf::Map& out) const {
    AdaptiveLatencyOptions options = setup_.remap.adapt;
    options.emission = setup_.emission;
    options.start = options.most = least.latency;
    options.least = std::min(std::max(least.lead, Duration{}), least.latency);
    RunningEmissions emissions(least.lead, AdaptiveLatency(options));
    std::int64_t sum_ns = 0, steps = 0, late = 0;
    each_mapped_step(setup_, kind, segments, [&](std::span<const MappedStep> mapped) {
      for (const MappedStep& step : mapped) {
        const StepEmission force = emissions.next(step);
        sum_ns += (force.at - force.slot.read).ns;
        late += force.late(setup_.emission).ns > 0;
        ++steps;
      }
    });
    if (steps > 0) out.adaptive = SizeWhatIf::Adaptive{Duration{sum_ns / steps}, late};
  }

  MapSetup setup_;
  std::span<const StrategyKind> maps_;
  const SizeOptions& options_;
  Duration period_;
};

}  // namespace

std::vector<SizeWhatIf> what_if_rows(const MapSetup& setup, std::span<const SegmentTiming> segments,
                                     std::span<const StrategyKind> maps, const SizeOptions& options) {
  if (options.what_ifs.empty() && !options.adaptive) return {};
  Rows rows(setup, maps, options);
  std::vector<SizeWhatIf> out{rows.row({}, segments, false)};
  for (const WhatIf& what_if : options.what_ifs) {
    out.push_back(rows.row(what_if, segments, false));
    if (const std::optional<WhatIf> own = causal(what_if); own && out.back().refused.empty())
      out.push_back(rows.row(*own, segments, true));
  }
  return out;
}

}  // namespace evenstep::internal
