#include "evenstep/harness/underrun_rate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/harness/segment_needs.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/trust.h"
#include "evenstep/reports/rate_bound.h"

namespace evenstep::internal {
namespace {

/// Counts the segments with a judged step, and those with an underrun. Steps must come in the order of segments.
class SegmentCount {
 public:
  void add(std::int64_t segment, bool underrun) {
    if (segment != segment_) ++count_.segments;
    if (underrun && segment != last_hit_) ++count_.hit, last_hit_ = segment;
    segment_ = segment;
  }
  RateCount count() const { return count_; }

 private:
  RateCount count_;
  std::int64_t segment_ = -1, last_hit_ = -1;
};

RateCount count_one(const Scenario& scenario, const TimingSpec& timing, const RateSignal& signal, Duration lead,
                    Duration latency) {
  const MapSetup setup = map_setup(scenario);
  const Emission emission = scenario.devices[signal.device].emission;
  RunningUnderruns underruns(setup.grids[signal.device], lead, latency, emission,
                             needed_ahead(setup, signal.kind, emission));
  SegmentCount count;
  each_run_step(setup, timing, signal.kind, lead, [&](std::span<const MappedStep> steps) {
    for (const MappedStep& step : steps) {
      const auto [missing_by, late_by] = underruns.next(step);
      if (step.begin < RealTime{scenario.warmup.ns}) continue;
      count.add(step.segment, (signal.side != UnderrunSide::force && missing_by.ns > 0) ||
                                  (signal.side != UnderrunSide::interaction && late_by.ns > 0));
    }
  });
  return count.count();
}

}  // namespace

std::vector<RateSignal> rate_signals(const Scenario& scenario) {
  std::vector<RateSignal> signals;
  for (std::size_t device = 0; device < scenario.devices.size(); ++device) {
    const std::string& name = scenario.devices[device].name;
    for (const StrategyKind kind : scenario.strategies) {
      if (!is_remap(kind)) continue;
      signals.push_back({name + ".interaction." + name_of(kind), kind, UnderrunSide::interaction, device});
      signals.push_back({name + ".force." + name_of(kind), kind, UnderrunSide::force, device});
      signals.push_back({name + ".buffers." + name_of(kind), kind, UnderrunSide::either, device});
    }
  }
  return signals;
}

RateCount count_underrun_segments(const Scenario& scenario, const RateSignal& signal, Duration lead, Duration latency,
                                  std::int64_t seeds) {
  RateCount all;
  TimingSpec timing = scenario.timing;
  for (std::int64_t i = 0; i < seeds; ++i) {
    timing.programmed.seed = scenario.timing.programmed.seed + static_cast<std::uint64_t>(i);
    const RateCount one = count_one(scenario, timing, signal, lead, latency);
    all.segments += one.segments;
    all.hit += one.hit;
  }
  return all;
}

std::int64_t judged_segments(const Scenario& scenario, StrategyKind kind) {
  SegmentCount count;
  each_run_step(map_setup(scenario), scenario.timing, kind, {}, [&](std::span<const MappedStep> steps) {
    for (const MappedStep& step : steps) {
      if (step.begin >= RealTime{scenario.warmup.ns}) count.add(step.segment, false);
    }
  });
  return count.count().segments;
}

RateBasis rate_basis(const Scenario& scenario, StrategyKind kind) {
  const auto computed = [](const Budget& budget) {
    return budget.kind == Budget::Kind::any_phase || budget.kind == Budget::Kind::this_phase;
  };
  RateBasis basis{.chosen = computed(scenario.remap.lead) || computed(scenario.remap.latency)};
  const MapSetup setup = map_setup(scenario);
  SegmentNeeds judged(setup.grids, setup.emission, RunningNeeds::Phase::this_one, needed_ahead(setup, kind, setup.emission));
  each_run_step(setup, scenario.timing, kind, {}, [&](std::span<const MappedStep> steps) {
    const auto before = std::count_if(steps.begin(), steps.end(),
                                      [&](const MappedStep& step) { return step.begin < RealTime{scenario.warmup.ns}; });
    judged.add(steps.subspan(static_cast<std::size_t>(before)));
  });
  const std::vector<SegmentNeed> needs = judged.take();
  if (scenario.timing.trace.empty()) {
    basis.alike = alike_segments(rounded_up(needs));
    return basis;
  }
  const SizeTrust trust = trust_in(needs);
  basis.alike = trust.alike;
  if (!trust.one_process()) basis.refused = not_one_process(trust);
  return basis;
}

double underrun_rate_at_most(const RateCount& count, const RateBasis& basis, double confidence) {
  if (basis.chosen) return chosen_rate_at_most(count.hit, count.segments, basis.alike, confidence);
  const auto independent = [&](std::int64_t segments) { return static_cast<double>(segments) / basis.alike; };
  return rate_at_most(static_cast<std::int64_t>(std::ceil(independent(count.hit))),
                      static_cast<std::int64_t>(independent(count.segments)), confidence);
}

std::int64_t clean_segments(double rate, double confidence, const RateBasis& basis) {
  const auto few = [&](std::int64_t segments) { return underrun_rate_at_most({segments, 0}, basis, confidence) > rate; };
  std::int64_t too_few = 0, enough = 1;
  for (; few(enough); enough *= 2) too_few = enough;
  while (enough - too_few > 1) {
    const std::int64_t middle = too_few + (enough - too_few) / 2;
    (few(middle) ? too_few : enough) = middle;
  }
  return enough;
}

std::int64_t seeds_with(const Scenario& scenario, StrategyKind kind, std::int64_t segments) {
  const std::int64_t each = judged_segments(scenario, kind);
  return each == 0 ? 0 : (segments + each - 1) / each;
}

std::int64_t seeds_judged(const Scenario& scenario, const Expectation& expectation, StrategyKind kind,
                          const RateBasis& basis) {
  const double most = *in_base(*expectation.max, "1", 0, scenario.nominal);
  const std::int64_t enough = seeds_with(scenario, kind, clean_segments(most, *expectation.confidence, basis));
  if (enough == 0) return 0;
  // If nothing is random every seed gives the same run, and running it again would prove nothing.
  return !seeds_differ(scenario) ? 1 : expectation.seeds > 0 ? expectation.seeds : enough;
}

bool seeds_differ(const Scenario& scenario) {
  return scenario.timing.trace.empty() && !is_periodic(scenario.timing.programmed);
}

}  // namespace evenstep::internal

namespace evenstep {

std::vector<std::string> explain_rates(const Scenario& scenario) {
  std::vector<std::string> lines;
  const auto remap = std::find_if(scenario.strategies.begin(), scenario.strategies.end(), is_remap);
  if (remap == scenario.strategies.end()) return lines;
  for (const Expectation& expectation : scenario.expectations) {
    if (!expectation.confidence) continue;
    const double most = *in_base(*expectation.max, "1", 0, scenario.nominal);
    const internal::RateBasis basis = internal::rate_basis(scenario, *remap);
    const std::int64_t segments = internal::clean_segments(most, *expectation.confidence, basis);
    const std::int64_t seeds = internal::seeds_with(scenario, *remap, segments);
    lines.push_back(fmt::format("line {}: {} underrun_rate <= {:.6g} at {:.6g} % needs {} segments without an underrun: {}",
                                expectation.place.line, expectation.signal, most, 100 * *expectation.confidence, segments,
                                !internal::seeds_differ(scenario)
                                    ? "every seed of this timing is the same, and has " +
                                          fmt::format("{}", internal::judged_segments(scenario, *remap))
                                : expectation.seeds > 0 ? fmt::format("{} clean seeds; {} are run", seeds, expectation.seeds)
                                                        : fmt::format("{} clean seeds", seeds)));
  }
  return lines;
}

}  // namespace evenstep
