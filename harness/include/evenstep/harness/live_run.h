#pragma once
/// A run on the wall clock: the device lane on a thread of its own (a second scheduler on the same epoch, the same
/// coroutine), the solver on a worker. What came from outside is kept, and gives
///   - an exact virtual twin: the same events, hence the same trace hash (`replay`), and
///   - shadows: the other strategies over the recorded samples and completions; their forces never reached the hand.

#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/live_devices.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_run.h"

namespace evenstep {

struct LiveRecording {
  StrategyRecord record;  ///< of the live strategy
  std::vector<DeviceInputs> inputs;
  std::vector<SegmentTiming> timing;  ///< segments and steps as they really ran
  RealTimeGrant device_grant, simulation_grant;
};

/// Why this scenario cannot run on a wall clock, with the remedy; empty if it can.
std::string wall_clock_objection(const Scenario& scenario);

/// Throws RunFailure, also where a device of `options` cannot be opened.
LiveRecording run_live(const Scenario& scenario, const StrategyPlan& plan, const LiveDeviceOptions& options,
                       const RunControl& control);
/// The exact twin. Its trace_hash equals the recording's, or the run was not reproducible.
StrategyRecord replay(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                      const RunControl& control);
StrategyRecord run_shadow(const Scenario& scenario, const StrategyPlan& plan, const LiveRecording& recording,
                          const RunControl& control);

}  // namespace evenstep
