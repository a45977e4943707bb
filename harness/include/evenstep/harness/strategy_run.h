#pragma once
/// Runs one strategy on a virtual clock, with a scheduler, devices, rings, solver and hash of its own.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/live_view.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_lanes.h"
#include "evenstep/harness/watched_solver.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/scheduler.h"

namespace evenstep {

struct RunControl {
  std::optional<std::uint64_t> permute_ties;
  SchedulerLimits limits;
  bool worker_thread = false;                      ///< run the solver on a worker even in virtual time (same bits)
  const std::atomic<bool>* interrupted = nullptr;  ///< set by a signal
  const std::atomic<bool>* interrupted_by_scenario = nullptr;  ///< set by [run] interrupt, for each strategy on its own
  bool is_interrupted() const {
    return (interrupted && interrupted->load()) || (interrupted_by_scenario && interrupted_by_scenario->load());
  }
  std::function<void(const std::string& strategy, double fraction)> progress;
  LiveView* view = nullptr;                       ///< the observer of a run on the wall clock; null: none
  bool picture = false;                           ///< a picture of the live strategy's tissue is kept (TissuePicture)
  std::shared_ptr<RowFiles> row_files = nullptr;  ///< where long records are kept; null: in memory
};

/// Throws RunFailure. If it is interrupted, it returns what was recorded so far (record.steps end early, record.interrupted
/// is set). However it ends, the simulated devices must no longer drive; if one does, that is the failure that is thrown.
StrategyRecord run_strategy(const Scenario& scenario, const StrategyPlan& plan, const RunControl& control);

// Shared with live runs.

/// The parts in which a run, a shadow and the ideal twin differ.
struct LaneParts {
  Clock& clock;
  Exchange& exchange;
  std::unique_ptr<StepTiming> timing;
  std::vector<HapticDevice*> devices;  ///< empty: a shadow
};
/// The scenario's solver. `watched` points to the same solver if a picture of its tissue is to be kept.
struct MaybeWatched {
  std::unique_ptr<Solver> solver;
  const WatchedSolver* watched = nullptr;
};
MaybeWatched make_watched_solver(const Scenario& scenario, StrategyKind kind, const RunControl& control);
/// Runs both lanes on one scheduler.
StrategyRecord run_lanes(const Scenario& scenario, const StrategyPlan& plan, LaneParts parts, const RunControl& control);
/// Throws RunFailure if the scheduler has failed; otherwise returns. `steps`, the number of steps made so far, is given as
/// the step of a failure that comes from the device.
void throw_if_failed(const RunStatus& status, const std::string& strategy, std::int64_t steps = -1);
struct SlicedRun {
  RunStatus status;
  bool interrupted = false;  ///< before its end
  RealTime reached;          ///< everything before it has happened
};
inline constexpr Duration kRunSlice{20'000'000};  ///< 20 ms: short enough that an interrupt seems immediate on both clocks
/// Runs in slices of virtual or wall time, so that an interrupt is noticed and progress is shown. `after_slice` is called at
/// the end of each slice that did not fail: all events before `until` have run.
SlicedRun run_in_slices(Scheduler& scheduler, RealTime end, const std::string& strategy, const RunControl& control,
                        const std::function<void(RealTime until)>& after_slice = {}, Duration slice = kRunSlice);

}  // namespace evenstep
