#include "evenstep/harness/strategy_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/exchange.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/scheduler/live_lanes.h"

namespace evenstep {

void throw_if_failed(const RunStatus& status, const std::string& strategy, std::int64_t steps) {
  if (status.end == RunEnd::limit) {
    throw RunFailure("limit", strategy + ": " + status.message,
                     "a lane may be waiting for its own instant; raise the limit if the run is really that long");
  }
  if (status.end != RunEnd::failed) return;
  try {
    std::rethrow_exception(status.failure);
  } catch (const RunFailure& failure) {
    throw RunFailure(failure.reason, strategy + ": " + failure.what(), failure.remedy, failure.step);
  } catch (const SolverError& error) {
    const RunFailure failure = run_failure(error);
    throw RunFailure(failure.reason, strategy + ": " + failure.what(), failure.remedy);
  } catch (const HandDiverged& error) {
    throw RunFailure("diverged", fmt::format("{}: {}", strategy, error.what()),
                     "a softer scene, a heavier or more damped hand, or a smaller force_limit, which bounds what shakes it",
                     steps);
  } catch (const DeviceError& error) {
    throw RunFailure("device", strategy + ": " + error.what(),
                     "check the device's cable and permissions; `evenstep list` shows what a scenario can name");
  } catch (const std::exception& error) {
    throw RunFailure("solver", strategy + ": " + error.what(),
                     "this is a defect of evenstep; please report it with the scenario");
  }
}

RunStatus run_in_slices(Scheduler& scheduler, RealTime end, const std::string& strategy, const RunControl& control) {
  constexpr Duration kSlice{20'000'000};  // 20 ms: an interrupt is heard within a human's patience on both clocks
  RunStatus status;
  for (RealTime until = RealTime{0} + kSlice;; until = until + kSlice) {
    status = scheduler.run(std::min(until, end));
    if (status.end == RunEnd::failed || status.end == RunEnd::limit || status.end == RunEnd::stopped ||
        status.end == RunEnd::idle)
      break;
    if (until >= end) break;
    if (control.interrupted && control.interrupted->load()) break;
    if (control.progress) control.progress(strategy, seconds(until) / seconds(end));
  }
  if (control.progress) control.progress(strategy, 1.0);
  return status;
}

StrategyRecord run_lanes(const Scenario& scenario, const StrategyPlan& plan, LaneParts parts, const RunControl& control) {
  StrategyLanes lanes(scenario, plan, make_scenario_solver(scenario, plan.kind), parts.exchange, std::move(parts.timing),
                      std::move(parts.devices));
  std::unique_ptr<Executor> executor = std::make_unique<InlineExecutor>();
  if (control.worker_thread) executor = std::make_unique<WorkerExecutor>(parts.clock);
  Scheduler scheduler(parts.clock, *executor, {control.limits, control.permute_ties, scenario.keep_rows});
  lanes.spawn(scheduler, scheduler);
  const RunStatus status = run_in_slices(scheduler, RealTime{scenario.run_duration.ns}, name_of(plan.kind), control);
  throw_if_failed(status, name_of(plan.kind), static_cast<std::int64_t>(lanes.record().steps.size()));
  StrategyRecord record = lanes.finish(scheduler.events());
  record.trace_hash = scheduler.trace_hash();  // also where no events are kept
  return record;
}

StrategyRecord run_strategy(const Scenario& scenario, const StrategyPlan& plan, const RunControl& control) {
  VirtualClock clock;
  SimulatedDevices devices(scenario, clock);
  const std::vector<LinkSpec> links = links_of(scenario, plan);
  if (plan.kind == StrategyKind::ideal) {
    IdealExchange exchange(links, devices.drivers(), motions_of(scenario));
    return run_lanes(scenario, plan, {clock, exchange, make_even_timing(scenario), devices.drivers()}, control);
  }
  DeviceExchange exchange(links, devices.drivers());
  return run_lanes(scenario, plan, {clock, exchange, make_timing(scenario), devices.drivers()}, control);
}

}  // namespace evenstep
