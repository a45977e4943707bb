#pragma once
/// From what a [[device]] says to the driver that runs and the simulated device below it.

#include <memory>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/format/scenario.h"

namespace evenstep::internal {

/// The device in software. Throws DeviceError for a driver that is not registered.
std::unique_ptr<SimulatedDevice> make_simulated(const DeviceSpec& device, const Clock& clock);
/// The driver, above a transport of either kind. Throws DeviceError where it cannot drive what is there.
std::unique_ptr<HapticDevice> make_driver(const DeviceSpec& device, HidTransport& transport);

}  // namespace evenstep::internal
