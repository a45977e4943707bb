#pragma once
/// The haptic loop: the two lanes of a haptic simulator, as in the paper's Figures 3 and 4. The same code runs on a virtual
/// clock, on a wall clock (each lane with its own scheduler and thread) and in replay; `direct`, `paper`, `phase_locked` and
/// `ideal` differ only in the map and the exchange that are passed in.

#include "evenstep/device/force_guard.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/loop/recorder.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/remap/remap_steps.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// The tick grid of a device, and the guard between the schedule and its motors.
struct DeviceLane {
  int tool = 0;
  Rate rate;
  RealTime first_tick;
  HapticDevice* device = nullptr;  ///< nullptr: a shadow, whose force is not sent to any device
  ForceGuard guard;
  std::int64_t skipped = 0;  ///< ticks left out because the tick before them ran late; counted at the next tick that runs
};

/// What is really done in the time of a visualization, on the executor of the simulation lane. Its real length then takes
/// the place of the programmed one.
class Visualization : public Work {
 public:
  virtual ~Visualization() = default;
  /// It is about to run; `programmed` is the length that the timing gives it, and `part` how much of a drawing it may do.
  virtual void begins(Duration programmed, const DrawingPart& part) = 0;
  /// Whether the last run finished a drawing.
  virtual bool finished() const { return true; }
};

/// Figure 2 a: the hand, in real time. One tick reads the device and drives it.
Task device_lane(Scheduler& scheduler, DeviceLane& lane, Exchange& exchange, DeviceRecorder& record);

/// Figures 3 and 4: for each segment a visualization and its steps. Each step reads the hand at its slot's time (3 a-c), and
/// its force gets an emission time (4 c-e). Without a `visualization` (always under a virtual clock) a visualization is a
/// wait of its programmed length.
Task simulation_lane(Scheduler& scheduler, StepTiming& timing, SlotMap& map, SolverStep& solver, Exchange& exchange,
                     StepRecorder& record, Visualization* visualization = nullptr);

}  // namespace evenstep
