#pragma once
/// Makes the driver of a [[device]], and the simulated device below it.

#include <memory>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/format/scenario.h"

namespace evenstep::internal {

/// The simulated device. Throws DeviceError for a driver that is not registered.
std::unique_ptr<SimulatedDevice> make_simulated(const DeviceSpec& device, const Clock& clock);
/// The driver, above a real or a simulated transport. Throws DeviceError if it cannot drive the device there.
std::unique_ptr<HapticDevice> make_driver(const DeviceSpec& device, HidTransport& transport);

}  // namespace evenstep::internal
