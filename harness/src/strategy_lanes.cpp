#include "evenstep/harness/strategy_lanes.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "evenstep/harness/rendering.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/reports/run_failure.h"
#include "judge.h"
#include "src/parts/undelayed_solver.h"
#include "src/plan/source_plan.h"
#include "src/plan/strategies.h"

namespace evenstep {
namespace {

/// Records how far back the reads of steps and the forces of ticks reach. A filter on the steps' reads counts steps, so it
/// may last a segment longer than on an even schedule.
void put_memory(const Scenario& scenario, const StrategyPlan& plan, StrategyRecord& record) {
  for (const LinkSpec& link : links_of(scenario, plan)) {
    Duration read = link.interaction.window, sent = link.force.window;
    if (link.interaction_filter)
      read = std::max(read, settling_time(*link.interaction_filter, link.step_rate) + scenario.nominal.segment);
    if (link.source) sent = std::max(sent, internal::memory_of(*link.source, scenario, plan));
    if (link.force_filter) sent = std::max(sent, settling_time(*link.force_filter, link.ticks.rate));
    record.interaction_memory = std::max(record.interaction_memory, read);
    record.force_memory = std::max(record.force_memory, sent);
  }
}

std::unique_ptr<SlotMap> map_of(const Scenario& scenario, const StrategyPlan& plan) {
  const MapSetup setup = map_setup(scenario);
  return make_map(setup, plan.kind, plan.lead, latency_of(setup, plan));
}

StrategyRecord start_record(const Scenario& scenario, const StrategyPlan& plan, const std::shared_ptr<RowFiles>& files) {
  StrategyRecord record = empty_record(files);
  record.name = name_of(plan.kind);
  record.variable_step = traits_of(plan.kind).varies_step;
  record.reference = traits_of(plan.kind).knows_motion;
  record.continues = traits_of(plan.kind).continues;
  record.look = internal::strategy_of(plan.kind).look;
  for (const DeviceSpec& device : scenario.devices) {
    DeviceRecord& kept = record.devices.emplace_back(empty_device_record(files));
    kept.name = device.name;
    kept.interpolates = device.emission == Emission::linear;
    kept.ahead = needed_ahead(map_setup(scenario), plan.kind, device.emission);
    kept.loop = loop_record(scenario, plan, device);
    if (const std::size_t d = record.devices.size() - 1; d < plan.predicted.size()) {
      kept.predicted_interaction_underruns = plan.predicted[d].interaction_underruns;
      kept.predicted_late_forces = plan.predicted[d].late_forces;
    }
  }
  put_memory(scenario, plan, record);
  const auto& [any, here] = plan.sizing;
  record.latency = {.lead = plan.lead,
                    .latency = plan.latency,
                    .least_any_phase_lead = any.lead,
                    .least_any_phase = any.latency,
                    .least_this_phase_lead = here.lead,
                    .least_this_phase = here.latency,
                    .lead_culprit = any.lead_culprit,
                    .latency_culprit = any.latency_culprit,
                    .interaction_capacity = static_cast<std::int64_t>(plan.interaction_capacity),
                    .force_capacity = static_cast<std::int64_t>(plan.force_capacity),
                    .least_entries = plan.least_entries,
                    .adapts = plan.adapts};
  return record;
}

UnderrunWords underrun_words(const RemapSpec& remap, StrategyKind kind) {
  return {traits_of(kind).predicts, name_of(remap.interaction_underrun), name_of(remap.force_underrun)};
}

/// Records the limits. An implicit method has none, and the spring has neither a method nor a limit.
void put_limits(const Scene& scene, const SolverInfo& info, SolverRecord& record) {
  const auto* tissue = std::get_if<TissueScene>(&scene.body);
  if (tissue == nullptr || !info.limit) return;
  record.method = name_of(info.method);
  record.iterations = info.iterations;
  if (!std::isfinite(info.limit->step_s)) return;
  const double substep_s = period_s(scene.step_rate) / info.substeps;
  record.step_limit_s = info.limit->step_s;
  record.rest_state_step_limit_s = info.limit->rest_state_step_s;
  record.stiffness_limit_N_per_m = tissue->stiffness_N_per_m * stiffness_margin(info.method, *info.limit, substep_s);
  record.limit_particle = info.limit->particle;
}

SolverRecord solver_record(Solver& solver, const Scene& scene, double seconds) {
  const SolverInfo& info = solver.info();
  const SolverVerdict verdict = solver.verdict();
  SolverRecord record{info.name, info.device, info.particles, info.substeps};
  put_limits(scene, info, record);
  record.non_finite = verdict.non_finite;
  record.first_bad_step = verdict.first_bad_step;
  record.energy_growth = verdict.energy_growth;
  record.memoryless = is_memoryless(scene);
  record.variable_step = scene.variable_step;
  record.steps_over_limit = verdict.steps_over_limit;
  record.step_over_limit_max = verdict.step_over_limit_max;
  record.has_energy = scene.needs_energy && accounts_energy(scene) &&
                      std::find(info.lacks.begin(), info.lacks.end(), "energy") == info.lacks.end();
  record.left_out = info.left_out;
  record.lacks = info.lacks;
  record.solver_seconds = seconds;
  return record;
}

/// Whether an expectation asks for the energy of this strategy's solver.
bool asks_for_energy(const Scenario& scenario, StrategyKind kind) {
  const std::vector<const Expectation*> conditions = conditions_of(scenario);
  return std::any_of(conditions.begin(), conditions.end(), [&](const Expectation* condition) {
    return condition->metric.starts_with("energy_") &&
           internal::matches(condition->signal, std::string("solver.") + name_of(kind));
  });
}

Scene scene_of(const Scenario& scenario, StrategyKind kind) {
  Scene scene = scenario.scene;
  scene.needs_energy = scene.needs_energy && asks_for_energy(scenario, kind);
  scene.variable_step = traits_of(kind).varies_step;
  return scene;
}

/// Records the summary of the contacts, if the device renders with them.
void put_contacts(const std::optional<RenderedContactsSummary>& contacts, DeviceRecord& record) {
  if (!contacts) return;
  record.counters["contact_stiffness"] = contacts->stiffest_N_per_m;
  record.counters["softened"] = static_cast<double>(contacts->softened);
}

/// Records what became of a source's forces on their way.
void put_source(const std::optional<SourceCounts>& counts, DeviceRecord& record) {
  if (!counts) return;
  record.counters["source_lost"] = static_cast<double>(counts->lost);
  record.counters["source_reordered"] = static_cast<double>(counts->reordered);
}

DeviceFlow flow_of(const DeviceLane& lane, const Exchange& exchange) {
  const ForceCounts& forces = exchange.force_counts(lane.tool);
  const auto ticks = [&](ReadStatus status) { return forces.ticks.at(static_cast<std::size_t>(status)); };
  return {.ticks_skipped = lane.skipped,
          .ticks_unforced = ticks(ReadStatus::empty),
          .ticks_underrun = ticks(ReadStatus::underrun),
          .ticks_overrun = ticks(ReadStatus::overrun),
          .ticks_on_time = ticks(ReadStatus::inside),
          .samples = static_cast<std::int64_t>(exchange.samples(lane.tool)),
          .samples_repeated = exchange.repeated_samples(lane.tool),
          .forces = static_cast<std::int64_t>(exchange.forces(lane.tool)),
          .forces_sent = forces.sent,
          .forces_overtaken = forces.overtaken,
          .forces_dropped = forces.dropped,
          .forces_pending = exchange.pending_forces(lane.tool)};
}

/// Records the energy that the scene stores when judging begins.
void put_stored(const Scenario& scenario, DeviceRecord& record) {
  const RealTime from{scenario.warmup.ns};
  const auto first =
      std::find_if(record.ticks.begin(), record.ticks.end(), [&](const TickRow& tick) { return tick.at >= from; });
  if (first == record.ticks.end()) return;
  const auto [x, y, z] = first->position_m;
  record.stored_J = stored_energy_J(scenario.scene, glm::dvec3(x, y, z));
}

}  // namespace

/// A timing that knows when all the steps that it has handed out were programmed to begin.
class CountedTiming final : public StepTiming {
 public:
  explicit CountedTiming(std::unique_ptr<StepTiming> timing) : timing_(std::move(timing)) {}
  bool next(SegmentTiming& segment) override {
    if (!timing_->next(segment)) return false;
    last_ = segment;
    steps_ += std::ssize(segment.steps);
    return true;
  }
  void visualized(Duration took, bool finished) override { timing_->visualized(took, finished); }
  /// How many steps are programmed to begin before `end`, including those of segments that nobody has asked for.
  std::int64_t steps_before(RealTime end) {
    SegmentTiming segment;
    while (last_.begin < end && next(segment)) {
    }
    const auto later = [&](const Interval& step) { return step.begin >= end; };
    return steps_ - std::count_if(last_.steps.begin(), last_.steps.end(), later);
  }

 private:
  std::unique_ptr<StepTiming> timing_;
  SegmentTiming last_;
  std::int64_t steps_ = 0;
};

std::unique_ptr<Solver> make_scenario_solver(const Scenario& scenario, StrategyKind kind) {
  try {
    return make_solver(scenario.solver, scene_of(scenario, kind), scenario.solver_options);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

StrategyLanes::StrategyLanes(const Scenario& scenario, const StrategyPlan& plan, std::unique_ptr<Solver> solver,
                             Exchange& exchange, std::unique_ptr<StepTiming> timing, std::vector<HapticDevice*> devices,
                             const std::shared_ptr<RowFiles>& row_files)
    : scenario_(scenario),
      scene_(scene_of(scenario, plan.kind)),
      exchange_(exchange),
      solver_(std::move(solver)),
      map_(map_of(scenario, plan)),
      timing_(std::make_unique<CountedTiming>(std::move(timing))),
      record_(start_record(scenario, plan, row_files)),
      event_recorder_(record_),
      step_(*solver_, scene_),
      step_recorder_(record_, underrun_words(scenario.remap, plan.kind)),
      lanes_(device_lanes(scenario, devices)),
      device_recorders_(record_.devices.begin(), record_.devices.end()) {}

void StrategyLanes::spawn(Scheduler& device, Scheduler& simulation, Visualization* visualization) {
  for (std::size_t tool = 0; tool < lanes_.size(); ++tool) {
    device.spawn(device_lane(device, lanes_[tool], exchange_, device_recorders_[tool]));
  }
  simulation.spawn(simulation_lane(simulation, *timing_, *map_, step_, exchange_, step_recorder_, visualization));
}

StrategyLanes::~StrategyLanes() = default;

void StrategyLanes::reserve(const std::vector<std::size_t>& ticks, std::size_t steps) {
  record_.steps.reserve(steps);
  for (std::size_t tool = 0; tool < record_.devices.size(); ++tool) {
    record_.devices[tool].ticks.reserve(ticks.at(tool));
    record_.devices[tool].steps.reserve(steps);
  }
}

void StrategyLanes::show(LoopWatch& watch) {
  for (std::size_t tool = 0; tool < device_recorders_.size(); ++tool)
    device_recorders_[tool].show(watch.ticks, static_cast<std::uint32_t>(tool));
  step_recorder_.show(watch.steps);
}

void EventRecorder::keep(const Event& event) {
  record_.trace_hash = chain(record_.trace_hash, event);
  const auto next_name = static_cast<std::uint16_t>(record_.event_names.size());
  const auto [name, added] = names_.try_emplace(event.name.text, next_name);
  if (added) record_.event_names.emplace_back(event.name.text);
  record_.events.push_back({event.time, static_cast<std::uint8_t>(event.lane), name->second, record_.trace_hash});
  ++record_.event_counts[std::string(lane_name(event.lane)) + "." + event.name.text];
}

void StrategyLanes::take_events(Scheduler& scheduler) {
  scheduler.take_events(taken_);
  for (const Event& event : taken_) keep(event);
}

StrategyRecord StrategyLanes::finish(RealTime end) {
  record_.steps_due = timing_->steps_before(end);
  record_.steps_begun = step_.begun;
  record_.emission_repairs = map_->emission_repairs();
  record_.latency_growths = map_->latency().growths();
  record_.solver = solver_record(*solver_, scene_, step_.seconds);
  internal::put_undelayed(scenario_, record_.devices);
  for (std::size_t tool = 0; tool < lanes_.size(); ++tool) {
    DeviceRecord& device = record_.devices[tool];
    device.counters = counters_of(lanes_[tool]);
    device.flow = flow_of(lanes_[tool], exchange_);
    put_contacts(exchange_.contacts(static_cast<int>(tool)), device);
    put_source(exchange_.source_counts(static_cast<int>(tool)), device);
    put_stored(scenario_, device);
    if (scenario_.devices[tool].hand || scenario_.devices[tool].is_real) continue;  // its true motion is not known
    for (std::size_t n = 0; n < device.steps.size(); ++n) {
      device.steps[n].true_position_m = to_vec3(position_m(scenario_.devices[tool].motion, record_.steps[n].read));
    }
  }
  return std::move(record_);
}

}  // namespace evenstep
