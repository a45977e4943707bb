#pragma once
/// How a board's firmware acts on the bytes that it gets. What all boards have in common is in SimulatedBoard.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "../descriptor_items.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep::internal {

struct FirmwareOptions {
  int pool_effects = 40;
  int block_load_error_at = -1;
  bool for_linux_6_1 = false;
};

class Firmware {
 public:
  virtual ~Firmware() = default;
  virtual std::vector<std::byte> report_descriptor() const = 0;
  virtual HidDeviceInfo info() const = 0;
  /// Whether the firmware has such an output report. `ms`: its clock.
  virtual bool take_output(std::span<const std::byte> report, std::int64_t ms) = 0;
  virtual bool take_feature(std::span<const std::byte> report) = 0;
  /// Its answer to a request for a feature report; empty: none.
  virtual std::vector<std::byte> answer(std::uint8_t id) = 0;
  /// `share`: the position, -1 to 1 along each axis.
  virtual std::vector<std::byte> position_report(const glm::dvec3& share) const = 0;
  /// The state reports that it has sent since the last call, each as the byte after its id.
  virtual std::vector<std::uint8_t> states() { return {}; }
  virtual std::vector<std::byte> state_report(std::uint8_t /*state*/) const { return {}; }
  virtual void see_switches(bool /*safety_switch*/, bool /*actuator_power*/) {}

  /// Ends the effects whose time is over; returns how many ended.
  virtual int end_effects(std::int64_t ms) = 0;
  /// Shares of full scale, -1 to 1. `slope`: the slope of the largest coefficient, as a multiple of full scale over half
  /// the travel; 0: the firmware's own.
  virtual glm::dvec3 force(const glm::dvec3& share, const glm::dvec3& slope) const = 0;
  virtual int playing() const = 0;
  virtual int allocated() const = 0;
  virtual bool actuators_enabled() const = 0;
};

std::unique_ptr<Firmware> openffboard(int axes, const FirmwareOptions& options);
std::unique_ptr<Firmware> arduino_joystick(const FirmwareOptions& options);
/// In what a board differs from a strict reading of the standard.
struct StrictQuirks {
  enum class Control { array_from_1, mask_from_0, two_from_0 };
  enum class Load { at_once, late, error_first, never, always_1 };
  bool silent_pool = false, short_replies = false, pool_count = true;
  int motors = 2;  ///< 1: along X; the joystick's Y is a pedal
  bool axes_enable = true, duration = true, endless = true, direction = true, obeys_direction = true;
  bool block_offset = true, negative_side = true, springs = true, springs_turn = false;
  Control control = Control::array_from_1;
  Load load = Load::at_once;
};
std::unique_ptr<Firmware> strict_board(StrictQuirks quirks, const FirmwareOptions& options);

// ---- bytes

inline std::uint8_t byte_at(std::span<const std::byte> report, std::size_t at) {
  return std::to_integer<std::uint8_t>(report[at]);
}
inline std::uint16_t word_at(std::span<const std::byte> report, std::size_t at) {
  return static_cast<std::uint16_t>(byte_at(report, at) | byte_at(report, at + 1) << 8);
}
inline std::int16_t signed_at(std::span<const std::byte> report, std::size_t at) {
  return static_cast<std::int16_t>(word_at(report, at));
}
inline std::vector<std::byte> bytes_of(std::initializer_list<int> values) {
  std::vector<std::byte> bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}
inline std::uint32_t long_word_at(std::span<const std::byte> report, std::size_t at) {
  return word_at(report, at) | std::uint32_t{word_at(report, at + 2)} << 16;
}
/// A position in counts of +-32767, little-endian.
inline void put_position(std::vector<std::byte>& bytes, double share) {
  const auto counts = static_cast<std::int32_t>(share * 32767 + (share < 0 ? -0.5 : 0.5));
  bytes.push_back(static_cast<std::byte>(counts & 0xFF));
  bytes.push_back(static_cast<std::byte>(counts >> 8 & 0xFF));
}

/// Report 1 of a joystick: bytes, the first of which is its id, and a position for each axis.
inline std::vector<std::byte> joystick_report(std::size_t before, const glm::dvec3& share, int axes) {
  std::vector<std::byte> bytes(before);
  bytes[0] = std::byte{1};
  for (int axis = 0; axis < axes; ++axis) put_position(bytes, share[axis]);
  return bytes;
}

/// Set Condition as two of the firmwares keep it, in counts; the third byte of the report is the axis.
struct ConditionCounts {
  std::int16_t center = 0, positive = 0, negative = 0;
  std::uint16_t positive_saturation = 0, negative_saturation = 0, dead_band = 0;
  bool acts() const { return (positive != 0 && positive_saturation != 0) || (negative != 0 && negative_saturation != 0); }
};
inline ConditionCounts condition_of(std::span<const std::byte> report) {
  return {signed_at(report, 3), signed_at(report, 5), signed_at(report, 7),
          word_at(report, 9),   word_at(report, 11),  word_at(report, 13)};
}

// ---- effects

template <class Effects, class Predicate>
int count(const Effects& effects, Predicate predicate) {
  return static_cast<int>(std::count_if(effects.begin(), effects.end(), predicate));
}
template <class Effects>
int count_playing(const Effects& effects) {
  return count(effects, [](const auto& effect) { return effect.plays; });
}
template <class Effects>
void stop_all(Effects& effects) {
  for (auto& effect : effects) effect.plays = false;
}
/// Ends those that have played for longer than their duration; returns how many.
template <class Effects>
int end_over(Effects& effects, std::int64_t ms, int infinite) {
  int ended = 0;
  for (auto& effect : effects) {
    if (!effect.plays || effect.duration_ms == infinite || ms - effect.started_ms <= effect.duration_ms) continue;
    effect.plays = false;
    ++ended;
  }
  return ended;
}

// ---- descriptors

/// Items that boards' descriptors repeat.
class BoardItems : public Items {
 public:
  static constexpr int kVariable = 0x02, kPadding = 0x03, kArray = 0x00;

  void outputs(std::initializer_list<int> of, int bits, std::int64_t minimum, std::int64_t maximum) {
    logical(minimum, maximum);
    format(bits, static_cast<int>(of.size()));
    usages(of);
    output(kVariable);
  }
  void output_padding(int bits) {
    format(bits, 1);
    output(kPadding);
  }
  void features(std::initializer_list<int> of, int bits, std::int64_t minimum, std::int64_t maximum) {
    logical(minimum, maximum);
    format(bits, static_cast<int>(of.size()));
    usages(of);
    feature(kVariable);
  }
  void feature_padding(int bits) {
    format(bits, 1);
    feature(kPadding);
  }
  /// A collection of which one usage is selected, counted from 1.
  void selector(int around, std::initializer_list<int> of, bool is_feature = false) {
    open(around);
    usages(of);
    logical(1, static_cast<std::int64_t>(of.size()));
    format(8, 1);
    is_feature ? feature(kArray) : output(kArray);
    close();
  }
  /// An effect's type: Constant, Ramp, Square, Sine, Triangle, Sawtooth Up and Down, Spring, Damper, Inertia, Friction.
  void effect_type(bool is_feature = false) {
    selector(0x25, {0x26, 0x27, 0x30, 0x31, 0x32, 0x33, 0x34, 0x40, 0x41, 0x42, 0x43}, is_feature);
  }
  void block_report(int usage_of_it, int id) {
    open_report(usage_of_it, id);
    outputs({0x22}, 8, 1, 40);
  }
  /// Begins the joystick with `axes` positions of +-32767 after `buttons` bits, in report 1.
  void joystick(int buttons, int axes) {
    page(0x01);
    usage(0x04);
    item(0xA0, 1);
    item(0x84, 1);
    page(0x09);
    item(0x18, 1);
    item(0x28, buttons);
    logical(0, 1);
    format(1, buttons);
    input(kVariable);
    page(0x01);
    item(0x18, 0x30);
    item(0x28, 0x30 + axes - 1);
    logical(-32767, 32767);
    format(16, axes);
    input(kVariable);
    page(0x0F);
  }
  /// What the device says of itself: paused, actuators enabled, safety switch, power, effect playing.
  void states(int id) {
    open_report(0x92, id);
    logical(0, 1);
    format(1, 5);
    usages({0x9F, 0xA0, 0xA4, 0xA6, 0x94});
    input(kVariable);
    format(3, 1);
    input(kPadding);
    close();
  }
  /// Which axes an effect acts along, and whether its direction counts instead.
  void axes_enable(int axes = 2) {
    open(0x55);
    page(0x01);
    axes == 1 ? outputs({0x30}, 1, 0, 1) : outputs({0x30, 0x31}, 1, 0, 1);
    close();
    page(0x0F);
    direction_enable(axes);
  }
  /// The rest of a byte of which `used` bits are used.
  void direction_enable(int used) {
    outputs({0x56}, 1, 0, 1);
    output_padding(7 - used);
  }
  /// A collection with a value for each axis, from 0 to `maximum` if one is given.
  void per_axis(int around, int axes, int bits, std::optional<std::int64_t> maximum = {}) {
    open(around);
    if (maximum) logical(0, *maximum);
    for (int axis = 1; axis <= axes; ++axis) item(0x08, 0x0A0000 + axis, 4);
    format(bits, axes);
    output(kVariable);
    close();
  }
  /// A command to the whole device, counted from `minimum`.
  void device_control(int id, int minimum = 1, int elements = 1) {
    open_report(0x96, id);
    usages({0x97, 0x98, 0x99, 0x9A, 0x9B, 0x9C});
    logical(minimum, minimum + 5);
    format(8, elements);
    output(kArray);
    close();
  }
  /// The same with a bit for each command.
  void device_control_mask(int id) {
    open_report(0x96, id);
    outputs({0x97, 0x98, 0x99, 0x9A, 0x9B, 0x9C}, 1, 0, 1);
    output_padding(2);
    close();
  }
  void constant_force(int id, int largest) {
    block_report(0x73, id);
    outputs({0x70}, 16, -largest, largest);
    close();
  }
  /// How a force rises and falls: attack and fade level, attack and fade time in milliseconds.
  void envelope(int id, int largest) {
    block_report(0x5A, id);
    outputs({0x5B, 0x5D}, 16, 0, largest);
    unit(0x1003, 0xFD);
    outputs({0x5C, 0x5E}, 32, 0, 32'767);
    unit(0, 0);
    close();
  }
  void operation(int id) {
    block_report(0x77, id);
    selector(0x78, {0x79, 0x7A, 0x7B});
    outputs({0x7C}, 8, 0, 255);
    close();
  }
  void block_free(int id) {
    block_report(0x90, id);
    close();
  }
  void gain(int id) {
    open_report(0x7D, id);
    outputs({0x7E}, 8, 0, 255);
    close();
  }
  void create_effect(int id) {
    open_report(0xAB, id);
    effect_type(true);
    page(0x01);
    features({0x3B}, 10, 0, 511);
    page(0x0F);
    feature_padding(6);
    close();
  }
  void block_load(int id) {
    open_report(0x89, id);
    features({0x22}, 8, 1, 40);
    selector(0x8B, {0x8C, 0x8D, 0x8E}, true);
    features({0xAC}, 16, 0, 65'535);
    close();
  }
  void pool(int id, bool count = true) {
    open_report(0x7F, id);
    features({0x80}, 16, 0, 65'535);
    if (count) features({0x83}, 8, 0, 255);
    features({0xA9, 0xAA}, 1, 0, 1);
    feature_padding(6);
    close();
  }
};

}  // namespace evenstep::internal
