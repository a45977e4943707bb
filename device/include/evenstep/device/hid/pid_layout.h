#pragma once
/// Where each value lies in the reports of a force feedback device of the PID class (HID usage page 0x0F). Values are found
/// in the report descriptor by usage and collection, never by report number or byte. Devices leave out much of the standard,
/// so everything is optional except what a constant force needs: effect block index and type in Set Effect, block index and
/// a signed magnitude in Set Constant Force, block index and start in Effect Operation.
///
/// The value that selects a usage is the place of the usage in the array's list, counted from the logical minimum. It is
/// counted from 1 if the logical minimum is 0 and the maximum is the number of usages: on such devices 0 means "none".

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/device/hid/report_descriptor.h"

namespace evenstep {

namespace pid {
inline constexpr std::uint32_t kPage = 0x0F0000;
/// X, Y, Z of the Generic Desktop page.
inline constexpr std::uint32_t kFirstAxis = 0x010030;
inline constexpr std::size_t kAxes = 3;
}  // namespace pid

/// A report to compose or to take apart.
struct PidReport {
  std::uint8_t id = 0;
  std::size_t size = 0;  ///< bytes, including the id (or the 0 in its place)
};

/// One value of a report.
struct PidValue {
  FieldLayout field;
  std::uint32_t index = 0;
};

/// A value to be set to choose one of several meanings: the selector of an array, or a bit of a mask.
struct PidChoice {
  PidValue where;
  std::uint32_t value = 0;
};

struct PidSetEffect {
  PidReport report;
  PidValue block;
  PidChoice constant;  ///< effect type Constant Force
  std::optional<PidChoice> spring;
  std::optional<PidValue> duration, trigger_repeat, sample_period, start_delay, gain, trigger_button, direction_enable;
  std::array<std::optional<PidValue>, pid::kAxes> axis_enable;
  std::vector<PidValue> directions;  ///< in the declared order; the first is the angle from north, clockwise
};
struct PidSetConstant {
  PidReport report;
  PidValue block, magnitude;
};
struct PidSetCondition {
  PidReport report;
  PidValue block, positive_coefficient;
  std::optional<PidValue> parameter_block, center, negative_coefficient, positive_saturation, negative_saturation, dead_band;
};
struct PidOperation {
  PidReport report;
  PidValue block;
  PidChoice start;
  std::optional<PidChoice> stop;
  std::optional<PidValue> loop_count;
};
struct PidBlockFree {
  PidReport report;
  PidValue block;
};
/// Each command is a choice of its own: a value of an 8-bit array, or a bit of a mask.
struct PidDeviceControl {
  PidReport report;
  std::optional<PidChoice> enable_actuators, disable_actuators, stop_all, reset, pause, resume;
};
struct PidDeviceGain {
  PidReport report;
  PidValue gain;
};
struct PidCreateEffect {  ///< feature report
  PidReport report;
  PidChoice constant;
  std::optional<PidChoice> spring;
  std::optional<PidValue> byte_count;
};
struct PidBlockLoad {  ///< feature report
  PidReport report;
  PidValue block;
  std::optional<PidChoice> success, full, error;
  std::optional<PidValue> ram_available;
};
struct PidPoolLayout {  ///< feature report
  PidReport report;
  std::optional<PidValue> ram_size, simultaneous, device_managed;
};
struct PidStateLayout {  ///< input report
  PidReport report;
  std::optional<PidValue> paused, actuators_enabled, safety_switch, override_switch, actuator_power, effect_playing, block;
};
struct PidPosition {  ///< input report
  PidReport report;
  PidValue value;
};

struct PidLayout {
  std::array<std::optional<PidPosition>, pid::kAxes> position;
  std::vector<PidReport> inputs;  ///< all input reports
  PidSetEffect set_effect;
  PidSetConstant set_constant;
  PidOperation operation;
  std::optional<PidSetCondition> set_condition;
  std::optional<PidBlockFree> block_free;
  std::optional<PidDeviceControl> device_control;
  std::optional<PidDeviceGain> device_gain;
  std::optional<PidCreateEffect> create_effect;
  std::optional<PidBlockLoad> block_load;
  std::optional<PidPoolLayout> pool;
  std::optional<PidStateLayout> state;
};

/// The error lists all that a constant force needs and the descriptor lacks.
Result<PidLayout, std::vector<std::string>> pid_layout(const ReportDescriptor& descriptor);

/// A value of a report as the transport delivers it; empty if the report is too short.
inline std::optional<std::int64_t> get(std::span<const std::byte> report, const PidValue& value) {
  return get(report, value.field, value.index);
}
/// Sets the nearest value that the field can hold; false if it can hold none.
bool set_nearest(std::span<std::byte> report, const PidValue& value, std::int64_t wanted);
/// Sets a bit of a mask, or all elements of an array.
bool choose(std::span<std::byte> report, const PidChoice& choice);
/// Seconds per count of a duration field: given by its unit exponent if its unit is one of time, otherwise a millisecond,
/// which is what devices mean.
double seconds_per_count(const FieldLayout& duration);
/// By convention 0xFFFF means for ever, whatever the logical range.
inline constexpr std::uint32_t kPidInfinite = 0xFFFF;
/// Whether the report contains this choice.
bool is_chosen(std::span<const std::byte> report, const PidChoice& choice);

}  // namespace evenstep
