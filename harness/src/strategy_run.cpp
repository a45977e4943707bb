#include "evenstep/harness/strategy_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/harness/visualization.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/scheduler/live_lanes.h"

namespace evenstep {
namespace {

/// [run] interrupt: does what the signal handler would do, in virtual time.
Task signal_lane(Scheduler& scheduler, RealTime at, std::atomic<bool>& interrupted) {
  co_await scheduler.until(at, Lane::completion, "signal");
  interrupted = true;
}

/// Where steps are so short that 20 ms have very many, an interrupt must not wait for all of these.
Duration slice_of(const ProgrammedTiming& timing) {
  constexpr std::int64_t kMostSteps = 10'000;
  const int most = timing.steps.empty() ? 0 : *std::max_element(timing.steps.begin(), timing.steps.end());
  const Duration step = timing.step.value_or(most > 0 ? Duration{period_ceil(timing.segment).ns / most} : kRunSlice);
  return step.ns > 0 && step.ns < kRunSlice.ns / kMostSteps ? step * kMostSteps : kRunSlice;
}

StrategyRecord record_until(StrategyLanes& lanes, Scheduler& scheduler, RealTime end) {
  StrategyRecord record = lanes.finish(end);
  record.trace_hash = scheduler.trace_hash();  // known even if no events are kept
  return record;
}

/// The record of what the lanes did until they failed; null if even that is impossible.
std::shared_ptr<StrategyRecord> record_so_far(StrategyLanes& lanes, Scheduler& scheduler) {
  try {
    lanes.take_events(scheduler);
    return std::make_shared<StrategyRecord>(record_until(lanes, scheduler, scheduler.now() + Duration{1}));
  } catch (const std::exception&) {
    return nullptr;
  }
}

void put_motors(SimulatedDevices& devices, StrategyRecord& record) {
  for (std::size_t tool = 0; tool < record.devices.size(); ++tool)
    record.devices[tool].counters.merge(devices.counters(tool));
}

}  // namespace

void throw_if_failed(const RunStatus& status, const std::string& strategy, std::int64_t steps) {
  if (status.end == RunEnd::limit) {
    throw RunFailure("limit", strategy + ": " + status.message,
                     "a lane may be waiting for its own instant; raise the limit if the run is really that long");
  }
  if (status.end != RunEnd::failed) return;
  try {
    std::rethrow_exception(status.failure);
  } catch (const RunFailure& failure) {
    throw RunFailure(failure.reason, strategy + ": " + failure.what(), failure.remedy,
                     failure.step < 0 ? steps : failure.step);
  } catch (const SolverError& error) {
    const RunFailure failure = run_failure(error);
    throw RunFailure(failure.reason, strategy + ": " + failure.what(), failure.remedy, steps);
  } catch (const HandDiverged& error) {
    throw RunFailure("diverged", fmt::format("{}: {}", strategy, error.what()),
                     "a softer scene, a heavier or more damped hand, or a smaller force_limit, which bounds what shakes it",
                     steps);
  } catch (const DeviceError& error) {
    throw RunFailure("device", strategy + ": " + error.what(),
                     "check the device's cable and permissions; `evenstep list` shows what a scenario can name", steps);
  } catch (const std::exception& error) {
    throw RunFailure("solver", strategy + ": " + error.what(),
                     "this is a defect of evenstep; please report it with the scenario");
  }
}

SlicedRun run_in_slices(Scheduler& scheduler, RealTime end, const std::string& strategy, const RunControl& control,
                        const std::function<void(RealTime until)>& after_slice, Duration slice) {
  SlicedRun run;
  for (RealTime until = RealTime{0} + slice;; until = until + slice) {
    run.reached = std::min(until, end);
    run.status = scheduler.run(run.reached);
    if (run.status.end == RunEnd::failed || run.status.end == RunEnd::limit || run.status.end == RunEnd::stopped) break;
    const bool idle = run.status.end == RunEnd::idle;  // and will be until the end
    if (after_slice) after_slice(idle ? end : run.reached);
    if (idle) break;
    if (until >= end) break;
    run.interrupted = control.is_interrupted();
    if (run.interrupted) break;
    if (control.progress) control.progress(strategy, seconds(until) / seconds(end));
  }
  if (control.progress) control.progress(strategy, 1.0);
  return run;
}

MaybeWatched make_watched_solver(const Scenario& scenario, StrategyKind kind, const RunControl& control) {
  std::unique_ptr<Solver> solver = make_scenario_solver(scenario, kind);
  const std::int64_t every = steps_between_poses(scenario.scene);
  if (!control.picture || kind != scenario.live || every == 0) return {std::move(solver), nullptr};
  auto watched = std::make_unique<WatchedSolver>(std::move(solver), scenario.scene.tool_count, every);
  WatchedSolver* const seen = watched.get();
  return {std::move(watched), seen};
}

StrategyRecord run_lanes(const Scenario& scenario, const StrategyPlan& plan, LaneParts parts, const RunControl& control) {
  auto [solver, watched] = make_watched_solver(scenario, plan.kind, control);
  StrategyLanes lanes(scenario, plan, std::move(solver), parts.exchange, std::move(parts.timing), std::move(parts.devices),
                      control.row_files);
  std::unique_ptr<Executor> executor = std::make_unique<InlineExecutor>();
  if (control.worker_thread) executor = std::make_unique<WorkerExecutor>(parts.clock);
  Scheduler scheduler(parts.clock, *executor, {control.limits, control.permute_ties, scenario.keep_rows});
  RunControl control_in_time = control;
  std::atomic<bool> interrupted{false};
  control_in_time.interrupted_by_scenario = &interrupted;
  if (scenario.interrupt) scheduler.spawn(signal_lane(scheduler, RealTime{scenario.interrupt->ns}, interrupted));
  lanes.spawn(scheduler, scheduler);
  const SlicedRun run = run_in_slices(
      scheduler, RealTime{scenario.run_duration.ns}, name_of(plan.kind), control_in_time,
      [&](RealTime) { lanes.take_events(scheduler); }, slice_of(scenario.timing.programmed));
  try {
    throw_if_failed(run.status, name_of(plan.kind), lanes.steps());
  } catch (RunFailure& failure) {
    failure.so_far = record_so_far(lanes, scheduler);
    throw;
  }
  StrategyRecord record = record_until(lanes, scheduler, run.reached);
  record.interrupted = run.interrupted;
  if (watched) record.tissue = picture_of(scenario, *watched);
  return record;
}

namespace {

StrategyRecord run_on(SimulatedDevices& devices, const Scenario& scenario, const StrategyPlan& plan, Clock& clock,
                      const RunControl& control) {
  const std::vector<LinkSpec> links = links_of(scenario, plan);
  if (traits_of(plan.kind).knows_motion) {
    IdealExchange exchange(links, devices.drivers(), motions_of(scenario));
    return run_lanes(
        scenario, plan,
        {clock, exchange, make_even_timing(scenario.scene.step_rate, scenario.nominal.step_run_time), devices.drivers()},
        control);
  }
  DeviceExchange exchange(links, devices.drivers());
  return run_lanes(scenario, plan, {clock, exchange, make_timing(scenario.timing), devices.drivers()}, control);
}

}  // namespace

StrategyRecord run_strategy(const Scenario& scenario, const StrategyPlan& plan, const RunControl& control) {
  VirtualClock clock;
  SimulatedDevices devices(scenario, clock);
  StrategyRecord record;
  try {
    record = run_on(devices, scenario, plan, clock, control);
  } catch (RunFailure& failure) {
    devices.stop();  // may throw a failure that is worse than the one that ended the run
    if (failure.so_far) put_motors(devices, *failure.so_far);
    throw;
  } catch (...) {
    devices.stop();
    throw;
  }
  devices.stop();
  put_motors(devices, record);
  return record;
}

}  // namespace evenstep
