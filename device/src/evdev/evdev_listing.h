#pragma once
/// What sysfs says of an event device, as text that anybody's device may have chosen.

#include <string>

#include "evenstep/device/evdev/evdev_file.h"

namespace evenstep::internal {

/// The first lines of files below /sys/class/input/eventN/device.
struct EvdevTexts {
  std::string name, vendor, product, serial;  // name, id/vendor, id/product, uniq
  std::string effects, axes, types;           // capabilities/ff, abs and ev
};

/// The listing, without a path and a refusal. Text that is no number counts as 0.
EvdevListing evdev_listing(const EvdevTexts& texts);
/// Whether the device can play any effect. A driver of the kernel's that names effects and then gives the device up leaves
/// their bits behind, without EV_FF among the types.
bool has_effects(const EvdevTexts& texts);

}  // namespace evenstep::internal
