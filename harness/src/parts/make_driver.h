#pragma once
/// Makes the driver of a [[device]], and the simulated device below it.

#include <memory>
#include <string>

#include "evenstep/clock/clock.h"
#include "evenstep/device/evdev/evdev_driver.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/format/scenario.h"

namespace evenstep::internal {

struct SimulatedParts {
  std::unique_ptr<SimulatedMotors> device;
  std::unique_ptr<HapticDevice> driver;  // declared after the device, so it is destroyed first
};
/// The simulated device and its driver. Throws DeviceError.
SimulatedParts make_simulated(const DeviceSpec& device, const Clock& clock);
/// The driver of a HID device. Throws DeviceError if it cannot drive the device there.
std::unique_ptr<HapticDevice> make_driver(const DeviceSpec& device, HidTransport& transport);
/// The driver of /dev/input/eventN, or of a simulated one. Throws DeviceError. `itself`, if it is not null, is set to the
/// driver, which may be wrapped.
std::unique_ptr<HapticDevice> make_evdev_driver(const EvdevSpec& spec, const DeviceSpec& device, EvdevNode& node,
                                                EvdevDriver** itself = nullptr);
/// The driver of a device of an Inverse Service; `device_id` empty: its only one. Throws DeviceError.
std::unique_ptr<HapticDevice> make_inverse3_driver(const Inverse3Spec& spec, Inverse3Link& link,
                                                   const std::string& device_id);

}  // namespace evenstep::internal
