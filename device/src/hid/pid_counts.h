#pragma once
/// Numbers in the counts of a PID device's fields.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "evenstep/device/hid/report_descriptor.h"

namespace evenstep::internal {

inline std::int64_t rounded(double value) { return static_cast<std::int64_t>(std::round(std::clamp(value, -1e15, 1e15))); }

/// The value at the given fraction of a field's range.
inline std::int64_t share(const FieldLayout& field, double fraction) {
  return field.logical_minimum + rounded(fraction * static_cast<double>(field.logical_maximum - field.logical_minimum));
}
inline double fraction_of(const FieldLayout& field, std::int64_t value) {
  const auto range = static_cast<double>(field.logical_maximum - field.logical_minimum);
  return range > 0 ? static_cast<double>(value - field.logical_minimum) / range : 1;
}

}  // namespace evenstep::internal
