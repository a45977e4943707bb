#pragma once
/// What a strategy's delay costs a device in stiffness, and the alpha that its local model plays with
/// (device/stiffness_laws.h).

#include <optional>
#include <string>

#include "evenstep/device/stiffness_laws.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/run_record.h"

namespace evenstep {

/// The delays of the loop over this device. L_e is that of the schedule: L + h/2, with hold emission half a slot more; for the
/// twin that knows the motion the same. Where forces are played as they come (`direct` and its like) it is the mean age, over
/// the run's own timing, of the sample that a tick's force answers; a filter's own delay is not in it.
LoopDelays loop_delays(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// device.render alpha, or the automatic one. Of a device that renders `local`.
double alpha_of(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// The stiffest contact that a device with a local model plays, N/m; infinite without a cap.
double cap_of(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// The delays and the laws of a device's loop, for the record; the stiffness that the hand feels where the scene says it.
LoopRecord loop_record(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);
/// One line for people: alpha* and the alpha used, b_eq and K_max. No line end.
std::string rendering_line(const Scenario& scenario, const StrategyPlan& plan, const DeviceSpec& device);

}  // namespace evenstep
