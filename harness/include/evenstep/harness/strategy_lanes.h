#pragma once
/// Everything that the two lanes of a strategy need in addition to schedulers, clock, devices and exchange: solver, map,
/// guards, recorders. It is the same on a virtual clock, on a wall clock and in replay.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/scheduler.h"

namespace evenstep {

class CountedTiming;

/// The scenario's solver, built and warmed up. On a wall clock this must happen before t = 0 is chosen. Throws RunFailure.
std::unique_ptr<Solver> make_scenario_solver(const Scenario& scenario, StrategyKind kind);

/// Adds events to a record, in the order in which they come: their rows, names, counts and hash.
class EventRecorder {
 public:
  explicit EventRecorder(StrategyRecord& record) : record_(record) {}
  void keep(const Event& event);

 private:
  StrategyRecord& record_;
  std::map<std::string, std::uint16_t> names_;
};

class StrategyLanes {
 public:
  /// If `devices` is empty, this is a shadow or a replay, whose forces are not sent to any device.
  StrategyLanes(const Scenario& scenario, const StrategyPlan& plan, std::unique_ptr<Solver> solver, Exchange& exchange,
                std::unique_ptr<StepTiming> timing, std::vector<HapticDevice*> devices,
                const std::shared_ptr<RowFiles>& row_files = nullptr);
  ~StrategyLanes();

  /// Starts the device lanes on one scheduler and the simulation lane on the other. In virtual time both are the same
  /// scheduler; on a wall clock each has its own thread. The schedulers must be destroyed before this object.
  /// `visualization` is what is really done in a visualization's time, on a wall clock; it must outlive the run.
  void spawn(Scheduler& device, Scheduler& simulation, Visualization* visualization = nullptr);

  /// Makes room for the rows of so many ticks of each device and so many steps.
  void reserve(const std::vector<std::size_t>& ticks, std::size_t steps);
  /// Shows in `watch` what the lanes do; call it before they begin. `watch` must live as long as they run.
  void show(LoopWatch& watch);
  /// The next event, in the order of all schedulers merged into one (scheduler/event.h).
  void keep(const Event& event) { event_recorder_.keep(event); }
  /// Keeps the events of a scheduler that runs both lanes; the scheduler then forgets them. Call it between two events.
  void take_events(Scheduler& scheduler);
  /// The record of what the lanes did before `end`.
  StrategyRecord finish(RealTime end);
  std::int64_t steps() const { return step_recorder_.steps(); }  ///< that have ended
  /// Where the lanes add their rows. A live run takes the rows out (except the last segment) between two events of the lane
  /// that adds them, and puts them back before finish().
  StrategyRecord& rows() { return record_; }

 private:
  const Scenario& scenario_;
  Scene scene_;  // the scenario's scene with the settings of this strategy
  Exchange& exchange_;
  std::unique_ptr<Solver> solver_;
  std::unique_ptr<SlotMap> map_;
  std::unique_ptr<CountedTiming> timing_;
  StrategyRecord record_;
  EventRecorder event_recorder_;
  std::vector<Event> taken_;
  SolverStep step_;
  StepRecorder step_recorder_;
  std::vector<DeviceLane> lanes_;
  std::vector<DeviceRecorder> device_recorders_;
};

}  // namespace evenstep
