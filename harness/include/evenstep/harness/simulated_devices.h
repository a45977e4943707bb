#pragma once
/// The scenario's devices in software: the real driver over a simulated transport, one per [[device]].

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "evenstep/harness/haptic_loop.h"
#include "evenstep/harness/scenario.h"
#include "evenstep/harness/sizing.h"

namespace evenstep {

/// The device of a [[device]], in software.
SimulatedTransport simulated_transport(const DeviceSpec& device, const Clock& clock);

class SimulatedDevices {
 public:
  SimulatedDevices(const Scenario& scenario, const Clock& clock);
  std::vector<HapticDevice*> drivers();
  const SimulatedTransport& transport(std::size_t device) const { return transports_[device]; }

 private:
  std::deque<SimulatedTransport> transports_;
  std::deque<ReferenceDriver> drivers_;
};

/// The links of one strategy with the ring sizes of its plan.
std::vector<LinkSpec> links_of(const Scenario& scenario, const StrategyPlan& plan);
std::vector<ProgrammedMotion> motions_of(const Scenario& scenario);
/// One lane per device; `devices` empty: shadows, nobody feels their force.
std::vector<DeviceLane> device_lanes(const Scenario& scenario, const std::vector<HapticDevice*>& devices);
/// Guard counters, and the driver's where there is a device.
std::map<std::string, double> counters_of(const DeviceLane& lane);

}  // namespace evenstep
