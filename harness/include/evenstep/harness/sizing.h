#pragma once
/// The sizing pass: runs the map alone over the timing and seed of a run, before t = 0, without solver or device. It gives
/// the least lead, latency and ring capacities, and predicts the counts of a run with other values. It keeps no steps, so
/// that its memory does not grow with the run; what needs the steps again walks the schedule again.

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// The timing's segments, with its frame governor if it has one.
std::unique_ptr<StepTiming> make_timing(const TimingSpec& timing);
/// The same for a wall clock: steps of step = "real" have no programmed length, and with steps = "spread" wait for their
/// slots.
std::unique_ptr<StepTiming> make_wall_timing(const TimingSpec& timing);
/// The even schedule of `ideal`: step n begins at its slot, tick n of the step rate, and runs for `run_time`, at most a
/// slot.
std::unique_ptr<StepTiming> make_even_timing(Rate step_rate, Duration run_time);

/// Everything that a map needs to run alone; no scene, no device and nothing else of a scenario.
struct MapSetup {
  RemapSpec remap;
  Rate step_rate{450, 1};
  std::vector<SamplingGrid> grids;       ///< when each device samples the hand
  Emission emission = Emission::linear;  ///< linear if any device interpolates, because that needs more latency
  RealTime end;                          ///< steps that end later do not count
  Duration source_period = {};           ///< the nominal slot
  bool has_clock = false;                ///< the loop keeps its own simulation time
  int taps = 1;                          ///< how many forces `polyphase` needs on each side
};
/// How much more latency this strategy needs than its map, for devices with this emission: `polyphase` needs the forces that
/// are due after a tick.
Duration needed_ahead(const MapSetup& setup, StrategyKind kind, Emission emission);
MapSetup map_setup(const Scenario& scenario);
std::vector<SamplingGrid> sampling_grids(const Scenario& scenario);
std::unique_ptr<SlotMap> make_map(const MapSetup& setup, StrategyKind kind, Duration lead, const AdaptiveLatency& latency);

/// Sees the mapped steps that end within the run, with the slots of lead 0: in order, a few at a time, perhaps none.
using VisitSteps = std::function<void(std::span<const MappedStep>)>;

struct Sizing {
  LatencyBudget any_phase, this_phase;  ///< their capacities are 0
  /// Whether a force needed a latency: false for a strategy without a map.
  bool has_steps() const { return any_phase.latency_culprit >= 0; }
};
Sizing size_map(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind);
/// The steps of a run with this lead. They include the waits of a gate; without a gate the lead does not matter.
void each_run_step(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, Duration lead,
                   const VisitSteps& visit);
/// The steps without a gate, over these segments.
void each_mapped_step(const MapSetup& setup, StrategyKind kind, std::span<const SegmentTiming> segments,
                      const VisitSteps& visit);
/// The same with any map that has not been told anything yet, and lead 0; for the steps that end before `end`.
void each_mapped_step(SlotMap& map, RealTime end, std::span<const SegmentTiming> segments, const VisitSteps& visit);
/// size_map for a gate with this lead: steps begin when their sample is there, and everything after them is pushed back. In
/// the budgets, `lead` is the one with which no step would wait, and `latency` the least for the given lead.
Sizing size_gated_map(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, Duration lead);

/// The lead, latency and rings of a strategy, and what the sizing pass predicts for it.
struct StrategyPlan {
  StrategyKind kind = StrategyKind::direct;
  Duration lead, latency;  ///< for an adaptive latency the most that it may become
  bool adapts = false;
  std::size_t interaction_capacity = 0, force_capacity = 0;
  std::optional<RingSizes> needed;  ///< what the timing needs, where the scenario says other capacities
  /// All 0 for direct and ideal. For a strategy that remaps, the latencies of its budgets are the least for the lead above.
  Sizing sizing;
  /// By the sizing pass, for each device: steps that begin in the judged span. Empty for a strategy that does not remap.
  struct Predicted {
    std::int64_t interaction_underruns = 0, late_forces = 0;
  };
  std::vector<Predicted> predicted;
  /// For a strategy that plays chunks: the least number of entries per chunk with which playback never runs dry in this run,
  /// because each chunk that is not lost arrives before the one before it is played to its end; else 0.
  std::int64_t least_entries = 0;
};
/// The steps of the run that this plan is for. Of a strategy without a map, all steps.
void each_run_step(const Scenario& scenario, const StrategyPlan& plan, const VisitSteps& visit);
/// The latency with which a map of this plan starts, fixed or adaptive.
AdaptiveLatency latency_of(const MapSetup& setup, const StrategyPlan& plan);
/// What the sizing pass predicts for an adaptive latency in this run, over the steps that begin in the judged span.
struct AdaptationForecast {
  double mean_s = 0;
  Duration largest;
  std::int64_t growths = 0;  ///< over the whole run
};
AdaptationForecast forecast_adaptation(const Scenario& scenario, const StrategyPlan& plan);
/// The plans of all strategies of the scenario, in its order. `ideal` gets the lead and latency of the `live` strategy, or
/// of the first one that remaps, so that it is the twin of that strategy.
std::vector<StrategyPlan> plan(const Scenario& scenario);
/// The plan of the twin with which deviation_from_ideal compares the strategy `of`.
StrategyPlan ideal_twin(const Scenario& scenario, const StrategyPlan& of);
/// Whether the metric compares with the twin.
bool compares_with_twin(std::string_view metric);

}  // namespace evenstep
