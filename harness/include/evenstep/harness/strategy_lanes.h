#pragma once
/// Everything the two lanes of one strategy need besides schedulers, clock, devices and exchange: solver, map, guards,
/// recorders. The same on a virtual clock, on a wall clock and in replay.

#include <memory>
#include <vector>

#include "evenstep/loop/exchange.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/scheduler.h"

namespace evenstep {

/// The scenario's solver, built and warmed up: on a wall clock before t = 0 is chosen. Throws RunFailure.
std::unique_ptr<Solver> make_scenario_solver(const Scenario& scenario, StrategyKind kind);

class StrategyLanes {
 public:
  /// `devices` empty: a shadow or a replay, nobody feels the forces.
  StrategyLanes(const Scenario& scenario, const StrategyPlan& plan, std::unique_ptr<Solver> solver, Exchange& exchange,
                std::unique_ptr<StepTiming> timing, std::vector<HapticDevice*> devices);

  /// The device lanes on one scheduler, the simulation lane on the other: the same one in virtual time, one per thread on a
  /// wall clock. The schedulers must end before this object.
  void spawn(Scheduler& device, Scheduler& simulation);

  /// What the lanes did. `events`: of all schedulers, in their one order (scheduler/event.h, merge).
  StrategyRecord finish(const std::vector<Event>& events);
  const StrategyRecord& record() const { return record_; }

 private:
  const Scenario& scenario_;
  Scene scene_;  // the scenario's, as this strategy integrates it
  Exchange& exchange_;
  std::unique_ptr<Solver> solver_;
  std::unique_ptr<SlotMap> map_;
  std::unique_ptr<StepTiming> timing_;
  StrategyRecord record_;
  SolverStep step_;
  StepRecorder step_recorder_;
  std::vector<DeviceLane> lanes_;
  std::vector<DeviceRecorder> device_recorders_;
};

}  // namespace evenstep
