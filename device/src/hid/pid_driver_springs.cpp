// The springs that PidDriver leaves to the device.
#include <algorithm>
#include <cmath>

#include "../effect_springs.h"
#include "evenstep/device/hid/pid_driver.h"
#include "pid_counts.h"

namespace evenstep {

using internal::rounded;

/// The counts of Set Condition; all 0 means no spring. Coefficients are >= 0, whatever sign the device wants.
struct PidDriver::Condition {
  std::int64_t center = 0, below = 0, above = 0, saturation = 0;
};

std::optional<PidDriver::Condition> PidDriver::counts_of(const DeviceSpring& wanted, int axis) const {
  const PidSetCondition& layout = *layout_.set_condition;
  const double half_travel_m = options_.travel_m[axis] / 2, full_scale_N = *options_.full_scale_N;
  const double below = wanted.below_N_per_m[axis], above = wanted.above_N_per_m[axis],
               slope = internal::full_slope_N_per_m(options_, axis);
  if (std::abs(wanted.center_m[axis]) > half_travel_m || (!layout.center && wanted.center_m[axis] != 0)) return std::nullopt;
  if (!layout.negative_coefficient && below != above) return std::nullopt;
  const double limit_N = std::min(wanted.limit_N[axis], largest_force_N());
  if (!layout.positive_saturation && limit_N < full_scale_N) return std::nullopt;
  const auto counts = [](double fraction, double most, const FieldLayout& field) {
    return rounded(std::min(fraction, most) * static_cast<double>(field.logical_maximum));
  };
  const auto coefficient = [&](double stiffness, const PidValue& value) {
    return counts(stiffness / slope, options_.gain, value.field);
  };
  Condition condition;
  if (layout.center) condition.center = counts(wanted.center_m[axis] / half_travel_m, 1, layout.center->field);
  condition.above = coefficient(above, layout.positive_coefficient);
  condition.below = layout.negative_coefficient ? coefficient(below, *layout.negative_coefficient) : condition.above;
  if (layout.positive_saturation)
    condition.saturation = counts(limit_N / full_scale_N, 1, layout.positive_saturation->field);
  return condition;
}

void PidDriver::render(const Condition& counts, DeviceSpring& rendered, int axis) const {
  const PidSetCondition& layout = *layout_.set_condition;
  const auto fraction = [](std::int64_t value, const FieldLayout& field) {
    return static_cast<double>(value) / static_cast<double>(field.logical_maximum);
  };
  const double slope = internal::full_slope_N_per_m(options_, axis), full_scale_N = *options_.full_scale_N;
  if (layout.center) rendered.center_m[axis] = fraction(counts.center, layout.center->field) * (options_.travel_m[axis] / 2);
  rendered.above_N_per_m[axis] = fraction(counts.above, layout.positive_coefficient.field) * slope;
  rendered.below_N_per_m[axis] = layout.negative_coefficient
                                     ? fraction(counts.below, layout.negative_coefficient->field) * slope
                                     : rendered.above_N_per_m[axis];
  rendered.limit_N[axis] = layout.positive_saturation
                               ? fraction(counts.saturation, layout.positive_saturation->field) * full_scale_N
                               : full_scale_N;
}

DeviceSpring PidDriver::write_spring(const DeviceSpring& wanted) {
  require_writable();
  DeviceSpring rendered;
  for (Effect& effect : effects_) {
    if (!effect.is_spring) continue;
    const int axis = static_cast<int>(effect.axis);
    const auto counts = counts_of(wanted, axis);
    if (counts) render(*counts, rendered, axis);
    want(effect, condition(effect, counts.value_or(Condition{})));
  }
  send_wanted();
  return rendered;
}

std::span<std::byte> PidDriver::no_spring(const Effect& effect) { return condition(effect, Condition{}); }

/// The block has the number of the axis, as on Linux. Firmware that applies block i to axis i then needs no direction, and
/// the blocks of other axes stay empty.
std::span<std::byte> PidDriver::condition(const Effect& effect, const Condition& counts) {
  const PidSetCondition& layout = *layout_.set_condition;
  const auto report = compose(layout.report);
  const std::int64_t sign = reverses_spring(effect.axis) ? -1 : 1;
  set_nearest(report, layout.block, effect.block);
  set_nearest(report, layout.positive_coefficient, sign * counts.above);
  const auto optional = [&](const std::optional<PidValue>& value, std::int64_t count) {
    if (value) set_nearest(report, *value, count);
  };
  optional(layout.parameter_block, static_cast<std::int64_t>(effect.axis));
  optional(layout.center, counts.center);
  optional(layout.negative_coefficient, sign * counts.below);
  optional(layout.positive_saturation, counts.saturation);
  optional(layout.negative_saturation, counts.saturation);
  optional(layout.dead_band, 0);
  return report;
}

double steepest_spring_N_per_m(const PidOptions& options) { return internal::steepest_spring_N_per_m(options, 3); }

}  // namespace evenstep
