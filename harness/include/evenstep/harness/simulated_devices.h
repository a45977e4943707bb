#pragma once
/// The scenario's devices in software: the real driver over a simulated transport, one per [[device]].

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/loop/haptic_loop.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"

namespace evenstep {

/// The device of a [[device]], in software.
std::unique_ptr<SimulatedDevice> simulated_transport(const DeviceSpec& device, const Clock& clock);
/// The driver that the [[device]] names, above a transport of either kind. Throws DeviceError where it cannot drive what is there.
std::unique_ptr<HapticDevice> make_driver(const DeviceSpec& device, HidTransport& transport);

/// Stops the driver of a simulated device. However a run ends, its motors are then off, its effects freed: throws RunFailure
/// ("still-driving", which no scenario can expect) if they are not.
void stop_simulated(const std::string& name, HapticDevice* driver, SimulatedDevice& device);
/// What its motors did, for DeviceRecord::counters.
std::map<std::string, double> motor_counters(SimulatedDevice& device);

class SimulatedDevices {
 public:
  /// Ready to be driven. Throws RunFailure.
  SimulatedDevices(const Scenario& scenario, const Clock& clock);
  std::vector<HapticDevice*> drivers();
  /// All of them: stop_simulated.
  void stop();
  /// Of device `tool`, after stop().
  std::map<std::string, double> counters(std::size_t tool) { return motor_counters(*devices_[tool]); }

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<SimulatedDevice>> devices_;
  std::vector<std::unique_ptr<HapticDevice>> drivers_;  // after what they talk to
};

/// The links of one strategy with the ring sizes of its plan.
std::vector<LinkSpec> links_of(const Scenario& scenario, const StrategyPlan& plan);
std::vector<ProgrammedMotion> motions_of(const Scenario& scenario);
/// One lane per device; `devices` empty: shadows, nobody feels their force.
std::vector<DeviceLane> device_lanes(const Scenario& scenario, const std::vector<HapticDevice*>& devices);
/// Guard counters, and the driver's where there is a device.
std::map<std::string, double> counters_of(const DeviceLane& lane);

}  // namespace evenstep
