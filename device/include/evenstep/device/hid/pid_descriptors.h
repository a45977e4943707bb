#pragma once
/// Report descriptors of two force feedback devices of our own, for simulation. The two are chosen to differ in everything
/// in which real devices of the PID class differ (docs/devices/hid.md has their reports), and everything that a device may
/// leave out can be left out.
///
///   mask    device control is eight 1-bit variables, start delay, magnitudes of +-32767, directions u16 of 0.01 degrees,
///           feature reports with ids of their own, positions of int16, unit exponents as nibbles
///   array   device control is an 8-bit array of 1 to 6, no start delay, +-10000, directions u8, feature reports with ids
///           of output reports, positions of 12 bits, physical ranges left over from other items, 4-byte usages

#include <cstddef>
#include <cstdint>
#include <vector>

namespace evenstep {

enum class PidFlavour { mask, array };

/// What the device has; by default everything.
struct PidDescriptorOptions {
  PidFlavour flavour = PidFlavour::mask;
  int axes = 2;  ///< 1 to 3: X, Y, Z
  bool duration = true, direction = true, axes_enable = true, effect_gain = true;
  bool parameter_block = true, center = true, negative_coefficient = true, saturation = true, negative_saturation = true,
       dead_band = true;
  bool conditions = true;  ///< Set Condition and the effect type Spring
  bool device_control = true, device_gain = true, block_free = true, stop_operation = true, pool = true, state = true;
  bool block_load = true;     ///< Create New Effect and Block Load; without them the driver numbers the blocks
  bool zero_is_none = false;  ///< arrays have the logical minimum 0, and the value 0 selects nothing
};

std::vector<std::byte> pid_descriptor(const PidDescriptorOptions& options);

}  // namespace evenstep
