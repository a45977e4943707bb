#include "evenstep/harness/underrun_rate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/harness/sizing.h"
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

RateCount count_one(const Scenario& scenario, const std::vector<MappedStep>& steps, const RateSignal& signal, Duration lead,
                    Duration latency) {
  const std::vector<bool> missing = interaction_underruns(steps, sampling_grids(scenario)[signal.device], lead);
  const Emission emission = scenario.devices[signal.device].emission;
  const std::vector<Duration> late =
      force_lateness(steps, lead, latency, emission, needed_ahead(map_setup(scenario), signal.kind, emission));
  SegmentCount count;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].begin < RealTime{scenario.warmup.ns}) continue;
    const bool hit =
        (signal.side != UnderrunSide::force && missing[i]) || (signal.side != UnderrunSide::interaction && late[i].ns > 0);
    count.add(steps[i].segment, hit);
  }
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
  const MapSetup setup = map_setup(scenario);
  TimingSpec timing = scenario.timing;
  for (std::int64_t i = 0; i < seeds; ++i) {
    timing.programmed.seed = scenario.timing.programmed.seed + static_cast<std::uint64_t>(i);
    const RateCount one = count_one(scenario, run_steps(setup, timing, signal.kind, lead), signal, lead, latency);
    all.segments += one.segments;
    all.hit += one.hit;
  }
  return all;
}

std::int64_t judged_segments(const Scenario& scenario, StrategyKind kind) {
  SegmentCount count;
  for (const MappedStep& step : run_steps(map_setup(scenario), scenario.timing, kind, {})) {
    if (step.begin >= RealTime{scenario.warmup.ns}) count.add(step.segment, false);
  }
  return count.count().segments;
}

std::int64_t clean_segments(double rate, double confidence) {
  auto segments = static_cast<std::int64_t>(std::ceil(std::log1p(-confidence) / std::log1p(-rate)));
  segments = std::max<std::int64_t>(segments, 1);
  while (rate_at_most(0, segments, confidence) > rate) ++segments;  // the quotient may have been rounded down
  return segments;
}

std::int64_t seeds_with(const Scenario& scenario, StrategyKind kind, std::int64_t segments) {
  const std::int64_t each = judged_segments(scenario, kind);
  return each == 0 ? 0 : (segments + each - 1) / each;
}

std::int64_t seeds_judged(const Scenario& scenario, const Expectation& expectation, StrategyKind kind) {
  const double most = *in_base(*expectation.max, "1", 0, scenario.nominal);
  const std::int64_t enough = seeds_with(scenario, kind, clean_segments(most, *expectation.confidence));
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
    const std::int64_t segments = internal::clean_segments(most, *expectation.confidence);
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
