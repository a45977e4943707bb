#pragma once
/// One strategy on a virtual clock: a scheduler, devices, rings, solver and hash of its own.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "evenstep/loop/exchange.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_lanes.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/scheduler.h"

namespace evenstep {

struct RunControl {
  std::optional<std::uint64_t> permute_ties;
  SchedulerLimits limits;
  bool worker_thread = false;  ///< run the solver on a worker even in virtual time (same bits)
  const std::atomic<bool>* interrupted = nullptr;               ///< set by a signal
  const std::atomic<bool>* interrupted_by_scenario = nullptr;   ///< by [run] interrupt: each strategy's own, in its own time
  bool is_interrupted() const {
    return (interrupted && interrupted->load()) || (interrupted_by_scenario && interrupted_by_scenario->load());
  }
  std::function<void(const std::string& strategy, double fraction)> progress;
};

/// Throws RunFailure. Interrupted: returns what is there (record.steps end early, record.interrupted). However it ends, its
/// simulated devices do not drive any more, or that is what it throws.
StrategyRecord run_strategy(const Scenario& scenario, const StrategyPlan& plan, const RunControl& control);

// Shared with live runs.

/// What differs between a run, a shadow and the ideal twin.
struct LaneParts {
  Clock& clock;
  Exchange& exchange;
  std::unique_ptr<StepTiming> timing;
  std::vector<HapticDevice*> devices;  ///< empty: a shadow
};
/// Both lanes on one scheduler.
StrategyRecord run_lanes(const Scenario& scenario, const StrategyPlan& plan, LaneParts parts, const RunControl& control);
/// Turns a scheduler's failed status into RunFailure; returns if there is none. `steps`: that the run had made, the step of a
/// failure that comes from the device.
void throw_if_failed(const RunStatus& status, const std::string& strategy, std::int64_t steps = -1);
struct SlicedRun {
  RunStatus status;
  bool interrupted = false;  ///< before its end
};
/// Runs in slices of virtual or wall time, so that an interrupt is heard and progress is shown.
SlicedRun run_in_slices(Scheduler& scheduler, RealTime end, const std::string& strategy, const RunControl& control);

}  // namespace evenstep
