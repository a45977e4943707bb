#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "evenstep/device/hid/report_descriptor.h"

namespace evenstep {
namespace {

/// The position of the element's first bit in the report; empty if there is nothing to get or set.
std::optional<std::size_t> first_bit(std::size_t report_size, const FieldLayout& field, std::uint32_t index) {
  if (index >= field.count || field.bits == 0 || field.bits > 32) return std::nullopt;
  const std::size_t first = 8 * field.id_bytes() + field.bit_offset + std::size_t{index} * field.bits;
  if (first + field.bits > 8 * report_size) return std::nullopt;
  return first;
}

struct Range {
  std::int64_t lowest, highest;
};

Range holdable(const FieldLayout& field) {
  const bool is_signed = field.logical_minimum < 0;
  const std::uint32_t bits = std::min<std::uint32_t>(field.bits, 32);
  if (bits == 0) return {0, -1};
  const std::int64_t lowest = is_signed ? -(std::int64_t{1} << (bits - 1)) : 0;
  const std::int64_t highest = (std::int64_t{1} << (is_signed ? bits - 1 : bits)) - 1;
  return {std::max(lowest, field.logical_minimum), std::min(highest, field.logical_maximum)};
}

/// value * 10^exponent. Powers up to 10^22 are exact; much larger ones soon exceed the range of doubles.
double scaled(double value, std::int32_t exponent) {
  if (value == 0) return 0;
  double power = 1;
  for (std::int32_t e = std::min(std::abs(std::max(exponent, -1000)), 1000); e > 0; --e) power *= 10;
  return exponent < 0 ? value / power : value * power;
}

std::pair<double, double> physical_range(const FieldLayout& field) {
  const bool declared = field.physical_minimum != 0 || field.physical_maximum != 0;
  const bool usable =
      declared && field.physical_minimum != field.physical_maximum && field.logical_minimum != field.logical_maximum;
  if (!usable) return {static_cast<double>(field.logical_minimum), static_cast<double>(field.logical_maximum)};
  return {static_cast<double>(field.physical_minimum), static_cast<double>(field.physical_maximum)};
}

/// Physical units per logical unit.
double slope(const FieldLayout& field) {
  const auto [low, high] = physical_range(field);
  const auto span = static_cast<double>(field.logical_maximum - field.logical_minimum);
  return span == 0 ? 1 : (high - low) / span;
}

}  // namespace

std::optional<std::int64_t> get(std::span<const std::byte> report, const FieldLayout& field, std::uint32_t index) {
  const auto first = first_bit(report.size(), field, index);
  if (!first) return std::nullopt;
  std::uint64_t gathered = 0;
  const std::size_t last_byte = (*first + field.bits - 1) / 8;
  for (std::size_t byte = *first / 8; byte <= last_byte; ++byte) {
    gathered |= std::to_integer<std::uint64_t>(report[byte]) << (8 * (byte - *first / 8));
  }
  const std::uint64_t range = std::uint64_t{1} << field.bits;
  const auto value = static_cast<std::int64_t>(gathered >> (*first % 8) & (range - 1));
  const bool negative = field.logical_minimum < 0 && value >= static_cast<std::int64_t>(range / 2);
  return negative ? value - static_cast<std::int64_t>(range) : value;
}

bool set_raw(std::span<std::byte> report, const FieldLayout& field, std::uint32_t index, std::uint32_t bits) {
  const auto first = first_bit(report.size(), field, index);
  if (!first) return false;
  const std::uint64_t mask = ((std::uint64_t{1} << field.bits) - 1) << (*first % 8);
  const std::uint64_t shifted = std::uint64_t{bits} << (*first % 8) & mask;
  const std::size_t last_byte = (*first + field.bits - 1) / 8;
  for (std::size_t byte = *first / 8; byte <= last_byte; ++byte) {
    const std::size_t shift = 8 * (byte - *first / 8);
    report[byte] =
        (report[byte] & static_cast<std::byte>(~mask >> shift & 0xFF)) | static_cast<std::byte>(shifted >> shift & 0xFF);
  }
  return true;
}

bool set(std::span<std::byte> report, const FieldLayout& field, std::uint32_t index, std::int64_t value) {
  return can_hold(field, value) && set_raw(report, field, index, static_cast<std::uint32_t>(value));
}

bool can_hold(const FieldLayout& field, std::int64_t value) {
  const auto [lowest, highest] = holdable(field);
  return lowest <= value && value <= highest;
}

std::optional<std::int64_t> nearest(const FieldLayout& field, std::int64_t value) {
  const auto [lowest, highest] = holdable(field);
  if (lowest > highest) return std::nullopt;
  return std::clamp(value, lowest, highest);
}

std::optional<std::int64_t> selector(const HidField& array, std::uint32_t usage) {
  const auto place = array.usages.find(usage);
  if (!place) return std::nullopt;
  const std::int64_t value = array.logical_minimum + *place;
  return can_hold(array, value) ? std::optional(value) : std::nullopt;
}

std::optional<std::uint32_t> selected(const HidField& array, std::int64_t value) {
  if (value < array.logical_minimum || value > array.logical_maximum) return std::nullopt;
  const std::int64_t place = value - array.logical_minimum;
  return place < array.usages.size() ? std::optional(array.usages[static_cast<std::uint32_t>(place)]) : std::nullopt;
}

double to_physical(const FieldLayout& field, std::int64_t logical) {
  const double above_minimum = static_cast<double>(logical - field.logical_minimum);
  return scaled(above_minimum * slope(field) + physical_range(field).first, field.unit_exponent);
}

std::optional<std::int64_t> to_logical(const FieldLayout& field, double physical) {
  // 10^-exponent; no unit has an exponent so large that it cannot be negated.
  const double unscaled = scaled(physical, -std::clamp(field.unit_exponent, -1000, 1000));
  const double logical =
      (unscaled - physical_range(field).first) / slope(field) + static_cast<double>(field.logical_minimum);
  if (!std::isfinite(logical)) return std::nullopt;
  return nearest(field, static_cast<std::int64_t>(std::round(std::clamp(logical, -1e15, 1e15))));
}

}  // namespace evenstep
