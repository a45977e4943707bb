#pragma once
/// A run on the wall clock. The device lane has a thread of its own (the same coroutine on a second scheduler with the same
/// epoch), and the solver runs on a worker. All inputs from outside are kept. From them follow
///   - an exact virtual twin with the same events, and so the same trace hash (`replay`), and
///   - shadows: the other strategies over the recorded samples and completions; their forces never reached the hand.

#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/input_log.h"
#include "evenstep/harness/live_devices.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_run.h"

namespace evenstep {

namespace internal {
class LiveLog;
}

struct LiveRecording {
  StrategyRecord record;  ///< of the live strategy
  std::vector<DeviceInputs> inputs;
  const std::vector<DeviceInputs>* read = nullptr;  ///< where the inputs are; null: in `inputs`
  const StrategyRecord* ran = nullptr;              ///< where segments and steps are as they really ran; null: in `record`
  std::optional<RealTime> unfinished;               ///< when the step that was running at the end was launched
  std::string visualization, drawing_png;           ///< as in RunRecord
  LaneCheck device_check, simulation_check;
  LiveRights rights;

  const StrategyRecord& as_ran() const { return ran ? *ran : record; }
  const std::vector<DeviceInputs>& as_read() const { return read ? *read : inputs; }
};

/// SCHED_FIFO priorities of the threads, all below the kernel's own threaded interrupts (50): the device above the
/// simulation, and the simulation above the solver, which may take all of a core for as long as a step lasts.
inline constexpr int kDevicePriority = 45, kSimulationPriority = 40, kSolverPriority = 35;

/// Why this scenario cannot run on a wall clock, with the remedy; empty if it can.
std::string wall_clock_objection(const Scenario& scenario);

/// Throws RunFailure, also if a device of `options` cannot be opened. `log` is given the inputs as they come; the caller
/// finishes it.
LiveRecording run_live(const Scenario& scenario, const StrategyPlan& plan, const LiveDeviceOptions& options,
                       const RunControl& control, internal::LiveLog* log = nullptr);
/// The exact twin. If its trace_hash is not that of the recording, the run was not reproducible.
StrategyRecord replay(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                      const RunControl& control);
/// The same for a recording that was read from its file, as far as it goes.
struct LogReplay {
  LiveRecording recording;  ///< its record is that of the replay, with lateness and counters of the live run
  RealTime until;           ///< everything before it was compared; if the run was recorded to its end, that end
  std::string difference;   ///< where the replay first differs from what was recorded; empty: nowhere
};
LogReplay replay(const Scenario& scenario, const StrategyPlan& plan, const InputLog& log, const RunControl& control);
StrategyRecord run_shadow(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                          const RunControl& control);

}  // namespace evenstep
