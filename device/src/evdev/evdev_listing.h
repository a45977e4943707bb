#pragma once
/// What sysfs says of an event device, as text that anybody's device may have chosen.

#include <string>

#include "evenstep/device/evdev/evdev_file.h"

namespace evenstep::internal {

/// The first lines of files below /sys/class/input/eventN/device.
struct EvdevTexts {
  std::string name, vendor, product, serial;  // name, id/vendor, id/product, uniq
  std::string effects, axes;                  // capabilities/ff, capabilities/abs
};

/// The listing, without a path and a refusal. Text that is no number counts as 0.
EvdevListing evdev_listing(const EvdevTexts& texts);
/// Whether the device can play any effect.
bool has_effects(const EvdevTexts& texts);

}  // namespace evenstep::internal
