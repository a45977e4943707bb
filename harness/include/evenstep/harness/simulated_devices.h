#pragma once
/// The devices of a scenario in software: for each [[device]] the real driver over a simulated transport.

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/loop/haptic_loop.h"

namespace evenstep {

/// Stops the driver of a simulated device. Whatever way a run ends, the motors must then be off and the effects freed; if
/// they are not, this throws RunFailure ("still-driving", which no scenario can expect).
void stop_simulated(const std::string& name, HapticDevice* driver, SimulatedMotors& device);
/// What the motors of a device did, for DeviceRecord::counters.
std::map<std::string, double> motor_counters(SimulatedMotors& device);

class SimulatedDevices {
 public:
  /// Makes the devices ready to be driven. Throws RunFailure.
  SimulatedDevices(const Scenario& scenario, const Clock& clock);
  std::vector<HapticDevice*> drivers();
  /// Calls stop_simulated for each device.
  void stop();
  /// The counters of device `tool`; call it after stop().
  std::map<std::string, double> counters(std::size_t tool) { return motor_counters(*devices_[tool]); }
  /// What the motors of device `tool` render at the clock's present time.
  glm::dvec3 motors_force_N(std::size_t tool) { return devices_[tool]->motors().force_N; }

 private:
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<SimulatedMotors>> devices_;
  std::vector<std::unique_ptr<HapticDevice>> drivers_;  // declared after the devices, so they are destroyed first
};

/// The links of one strategy with the ring sizes of its plan.
std::vector<LinkSpec> links_of(const Scenario& scenario, const StrategyPlan& plan);
std::vector<ProgrammedMotion> motions_of(const Scenario& scenario);
/// One lane per device. If `devices` is empty the lanes are those of a shadow, whose forces are not sent to any device.
std::vector<DeviceLane> device_lanes(const Scenario& scenario, const std::vector<HapticDevice*>& devices);
/// The counters of the guard, and of the driver if there is a device.
std::map<std::string, double> counters_of(const DeviceLane& lane);

}  // namespace evenstep
