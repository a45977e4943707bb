#include "evenstep/harness/strategy_run.h"

#include <algorithm>
#include <deque>
#include <map>
#include <memory>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/exchange.h"
#include "evenstep/harness/haptic_loop.h"
#include "evenstep/harness/recorder.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/scheduler/live_lanes.h"

namespace evenstep {
namespace {

/// The words of [expect_stop] reason.
std::string reason_of(const SolverError& error) {
  switch (error.fault()) {
    case SolverFault::unstable_step: return "unstable-step";
    case SolverFault::bad_input: return "bad-input";
    case SolverFault::unavailable:
    case SolverFault::bad_scene:
    case SolverFault::out_of_memory: return "solver";
  }
  return "solver";
}

}  // namespace

StrategyRecord start_record(const Scenario& scenario, const StrategyPlan& plan) {
  StrategyRecord record;
  record.name = name_of(plan.kind);
  for (const DeviceSpec& device : scenario.devices) {
    DeviceRecord& kept = record.devices.emplace_back();
    kept.name = device.name;
  }
  const auto& [steps, any, here] = plan.sizing;
  record.latency = {plan.lead, plan.latency, any.lead, any.latency, here.lead, here.latency, any.lead_culprit,
                    any.latency_culprit, static_cast<std::int64_t>(plan.interaction_capacity),
                    static_cast<std::int64_t>(plan.force_capacity), plan.predicted_interaction_underruns,
                    plan.predicted_late_forces};
  return record;
}

std::unique_ptr<Solver> make_scenario_solver(const Scenario& scenario) {
  SolverOptions options;
  options.work_group_size = scenario.work_group_size;
  try {
    return make_solver(scenario.solver, scenario.scene, options);
  } catch (const SolverError& error) {
    throw RunFailure(reason_of(error), error.what(), error.remedy());
  }
}

namespace {

SolverRecord solver_record(Solver& solver, double seconds, bool has_energy) {
  const SolverInfo& info = solver.info();
  const SolverVerdict verdict = solver.verdict();
  SolverRecord record{info.name, info.device, info.particles, info.substeps};
  if (info.limit) {
    record.step_limit_s = info.limit->step_s;
    record.rest_state_step_limit_s = info.limit->rest_state_step_s;
  }
  record.non_finite = verdict.non_finite;
  record.first_bad_step = verdict.first_bad_step;
  record.energy_growth = verdict.energy_growth;
  record.has_energy = has_energy;
  record.left_out = info.left_out;
  record.solver_seconds = seconds;
  return record;
}

}  // namespace

void keep_events(const std::vector<Event>& events, StrategyRecord& record) {
  std::map<std::string, std::uint16_t> names;
  std::uint64_t hash = 0;
  record.events.reserve(events.size());
  for (const Event& event : events) {
    hash = chain(hash, event);
    const auto [name, added] = names.try_emplace(event.name.text, static_cast<std::uint16_t>(record.event_names.size()));
    if (added) record.event_names.emplace_back(event.name.text);
    record.events.push_back({event.time, static_cast<std::uint8_t>(event.lane), name->second, hash});
    ++record.event_counts[std::string(lane_name(event.lane)) + "." + event.name.text];
  }
  record.trace_hash = hash;
}

void throw_if_failed(const RunStatus& status, const std::string& strategy) {
  if (status.end == RunEnd::limit) {
    throw RunFailure("limit", strategy + ": " + status.message, "a lane may be waiting for its own instant; raise the limit if the run is really that long");
  }
  if (status.end != RunEnd::failed) return;
  try {
    std::rethrow_exception(status.failure);
  } catch (const RunFailure& failure) {
    throw RunFailure(failure.reason, strategy + ": " + failure.what(), failure.remedy, failure.step);
  } catch (const SolverError& error) {
    throw RunFailure(reason_of(error), strategy + ": " + error.what(), error.remedy());
  } catch (const DeviceError& error) {
    throw RunFailure("device", strategy + ": " + error.what(), "check the device's cable and permissions; `evenstep list` shows what a scenario can name");
  } catch (const std::exception& error) {
    throw RunFailure("solver", strategy + ": " + error.what(), "this is a defect of evenstep; please report it with the scenario");
  }
}

RunStatus run_in_slices(Scheduler& scheduler, RealTime end, const std::string& strategy, const RunControl& control) {
  constexpr Duration kSlice{20'000'000};   // 20 ms: an interrupt is heard within a human's patience on both clocks
  RunStatus status;
  for (RealTime until = RealTime{0} + kSlice;; until = until + kSlice) {
    status = scheduler.run(std::min(until, end));
    if (status.end == RunEnd::failed || status.end == RunEnd::limit || status.end == RunEnd::stopped || status.end == RunEnd::idle) break;
    if (until >= end) break;
    if (control.interrupted && control.interrupted->load()) break;
    if (control.progress) control.progress(strategy, seconds(until) / seconds(end));
  }
  if (control.progress) control.progress(strategy, 1.0);
  return status;
}

StrategyRecord run_lanes(const Scenario& scenario, const StrategyPlan& plan, const LaneParts& parts, const RunControl& control) {
  StrategyRecord record = start_record(scenario, plan);
  const std::unique_ptr<Solver> solver = make_scenario_solver(scenario);
  const std::unique_ptr<SlotMap> map = make_map(scenario, plan.kind, plan.lead, plan.latency);
  SolverStep step(*solver, parts.exchange.tool_count(), scenario.scene.needs_state_digest);
  StepRecorder step_recorder(record);
  std::vector<DeviceLane> lanes = device_lanes(scenario, parts.devices);
  std::vector<DeviceRecorder> recorders(record.devices.begin(), record.devices.end());

  const std::unique_ptr<Executor> executor =
      control.worker_thread ? std::unique_ptr<Executor>(std::make_unique<WorkerExecutor>(parts.clock)) : std::make_unique<InlineExecutor>();
  Scheduler scheduler(parts.clock, *executor, {control.limits, control.permute_ties, true});
  for (std::size_t tool = 0; tool < lanes.size(); ++tool) {
    scheduler.spawn(device_lane(scheduler, lanes[tool], parts.exchange, recorders[tool]));
  }
  scheduler.spawn(simulation_lane(scheduler, parts.timing, *map, step, parts.exchange, step_recorder));
  const RunStatus status = run_in_slices(scheduler, RealTime{scenario.run_duration.ns}, record.name, control);
  throw_if_failed(status, record.name);

  keep_events(scheduler.events(), record);
  finish_record(*map, *solver, step, lanes, scenario, record);
  return record;
}

void finish_record(const SlotMap& map, Solver& solver, const SolverStep& step, const std::vector<DeviceLane>& lanes,
                   const Scenario& scenario, StrategyRecord& record) {
  record.emission_repairs = map.emission_repairs();
  record.solver = solver_record(solver, step.seconds, scenario.scene.needs_energy);
  for (std::size_t tool = 0; tool < lanes.size(); ++tool) {
    DeviceRecord& device = record.devices[tool];
    device.counters = counters_of(lanes[tool]);
    for (std::size_t n = 0; n < device.steps.size(); ++n) {
      device.steps[n].true_position_m = to_vec3(position_m(scenario.devices[tool].motion, record.steps[n].read));
    }
  }
}

StrategyRecord run_strategy(const Scenario& scenario, const StrategyPlan& plan, const RunControl& control) {
  VirtualClock clock;
  SimulatedDevices devices(scenario, clock);
  const std::vector<Emission> emissions = emissions_of(scenario);
  const RingSizes rings{plan.interaction_capacity, plan.force_capacity};
  if (plan.kind == StrategyKind::ideal) {
    IdealExchange exchange(rings, emissions, devices.drivers(), motions_of(scenario));
    return run_lanes(scenario, plan, {clock, exchange, *make_even_timing(scenario), devices.drivers()}, control);
  }
  DeviceExchange exchange(rings, emissions, devices.drivers());
  return run_lanes(scenario, plan, {clock, exchange, *make_timing(scenario), devices.drivers()}, control);
}

}  // namespace evenstep
