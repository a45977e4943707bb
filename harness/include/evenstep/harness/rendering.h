#pragma once
/// How much stiffness the delay of a strategy costs a device, and the alpha that its local model uses
/// (device/stiffness_laws.h).

#include <optional>
#include <string>

#include "evenstep/device/stiffness_laws.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/run_record.h"

namespace evenstep {

/// The delays of the loop over this device. L_e is the delay of the schedule, L + h/2, with hold emission half a slot more;
/// it is the same for the twin that knows the motion. For strategies that play forces as they come (`direct` and similar
/// ones) it is the mean age, over the timing of this run, of the sample that the force of a tick answers; between two forces
/// (`interpolated`) it lies between their samples. The delay of a filter is not included.
LoopDelays loop_delays(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// device.render alpha, or the automatic one; for a device that renders `local`.
double alpha_of(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// The stiffest contact that a device with a local model plays, N/m; infinite without a cap. If two hands both play their
/// coupling, it is the lesser of their two caps, which limits both together.
double cap_of(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// Whether one cap limits both hands together (device/renderer.h, softened_together): both play their coupling, and one of
/// them has a cap.
bool capped_together(const Scenario& scenario, const StrategyPlan& plan);
/// The delays and the laws of a device's loop for the record, with the stiffness that the hand feels if the scene has a
/// value for it.
LoopRecord loop_record(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// A line for people, without a line end: alpha* and the alpha used, b_eq and K_max.
std::string rendering_line(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);

}  // namespace evenstep
