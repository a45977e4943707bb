#pragma once
/// A device that the program has registered.

#include <memory>
#include <string>

#include "evenstep/clock/clock.h"
#include "evenstep/format/scenario.h"

namespace evenstep::internal {

std::unique_ptr<SimulatedGrip> make_grip(const DeviceSpec& device, const Clock& clock);
/// With a grip a simulated device, otherwise the real one at `path`. Throws DeviceError, which names the device, if it
/// cannot be made; its functions throw the same, or HandDiverged.
std::unique_ptr<HapticDevice> make_foreign_device(const ForeignDriverSpec& spec, const DeviceSpec& device,
                                                  SimulatedGrip* grip, const std::string& path);

}  // namespace evenstep::internal
