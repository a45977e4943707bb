#pragma once
/// The sizing pass: the map alone over this very timing and seed, before t = 0. No solver, no device. It gives the least
/// lead, latency and ring capacities, and predicts what a run with other values will count.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

std::unique_ptr<StepTiming> make_timing(const Scenario& scenario);
/// The even schedule of `ideal`: step n begins at its slot, tick n of the step rate.
std::unique_ptr<StepTiming> make_even_timing(const Scenario& scenario);
std::unique_ptr<SlotMap> make_map(const Scenario& scenario, StrategyKind kind, Duration lead,
                                  const AdaptiveLatency& latency);
std::vector<SamplingGrid> sampling_grids(const Scenario& scenario);
/// Linear if any device interpolates: the stricter need.
Emission strictest_emission(const Scenario& scenario);

struct Sizing {
  std::vector<MappedStep> steps;  ///< mapped steps that end within the run, with lead 0
  LatencyBudget any_phase;
  LatencyBudget this_phase;
};
Sizing size_map(const Scenario& scenario, StrategyKind kind);
/// The mapped steps of a run with this lead: a gate's waits are in them, and there only does the lead matter.
std::vector<MappedStep> run_steps(const Scenario& scenario, StrategyKind kind, Duration lead);
/// The mapped steps without a gate, over these segments instead of the scenario's own timing: in order, some at a time, and
/// nobody keeps them.
void each_mapped_step(const Scenario& scenario, StrategyKind kind, std::span<const SegmentTiming> segments,
                      const std::function<void(std::span<const MappedStep>)>& visit);
/// size_map for a gate with this lead: steps begin when their sample is there, and what follows is pushed back. `lead` of
/// the budgets is what would spare all waiting, `latency` the least with the lead given.
Sizing size_gated_map(const Scenario& scenario, StrategyKind kind, Duration lead);

/// What one strategy runs with, and what the sizing pass says of it.
struct StrategyPlan {
  StrategyKind kind = StrategyKind::direct;
  Duration lead, latency;                            ///< of a latency that adapts, the most it may become
  bool adapts = false;
  std::size_t interaction_capacity = 0, force_capacity = 0;
  Sizing sizing;                                     ///< empty for direct and ideal
  std::int64_t predicted_interaction_underruns = 0;  ///< worst device; steps that begin in the judged span
  std::int64_t predicted_late_forces = 0;
};
/// What a map of this plan starts with: the fixed latency, or the one that adapts.
AdaptiveLatency latency_of(const Scenario& scenario, const StrategyPlan& plan);
/// What a latency that adapts will do in this run, by the sizing pass: over the steps that begin in the judged span.
struct AdaptationForecast {
  double mean_s = 0;
  Duration largest;
  std::int64_t growths = 0;                          ///< of the whole run
};
AdaptationForecast forecast_adaptation(const Scenario& scenario, const StrategyPlan& plan);
/// Plans for all strategies of the scenario, in its order. `ideal` takes lead and latency of `live`, or of the first
/// remapping strategy, so that it is that one's twin.
std::vector<StrategyPlan> plan(const Scenario& scenario);
/// The twin that deviation_from_ideal compares `of` with.
StrategyPlan ideal_twin(const Scenario& scenario, const StrategyPlan& of);

}  // namespace evenstep
