#include "evenstep/device/hid/reference_device.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace evenstep::reference_device {
namespace {

constexpr std::uint8_t kInputId = 1;
constexpr std::uint8_t kOutputId = 2;

/// docs/devices/reference-device.md explains it byte by byte. HID's "SI linear" unit system uses centimetres and grams:
/// 1 nm = 1e-7 cm, and 1 uN = 1e-1 g cm/s^2, hence the exponents -7 and -1 (a 4-bit two's complement nibble).
constexpr std::uint8_t kDescriptor[] = {
    0x06, 0x00,      0xFF,                    // Usage Page (vendor-defined 0xFF00)
    0x09, 0x01,                               // Usage (1: the device)
    0xA1, 0x01,                               // Collection (Application)
    0x75, 0x20,                               //   Report Size (32)
    0x85, kInputId,                           //   Report ID (1)
    0x15, 0x00,                               //   Logical Minimum (0)
    0x27, 0xFF,      0xFF, 0xFF, 0xFF,        //   Logical Maximum (2^32 - 1)
    0x95, 0x01,                               //   Report Count (1)
    0x09, 0x02,                               //   Usage (2: sequence)
    0x81, 0x02,                               //   Input (Data, Variable, Absolute)
    0x66, 0x01,      0x10,                    //   Unit (s)
    0x55, 0x0A,                               //   Unit Exponent (-6)
    0x09, 0x03,                               //   Usage (3: device time)
    0x81, 0x02,                               //   Input (Data, Variable, Absolute)
    0x17, 0x00,      0x00, 0x00, 0x80,        //   Logical Minimum (-2^31)
    0x27, 0xFF,      0xFF, 0xFF, 0x7F,        //   Logical Maximum (2^31 - 1)
    0x65, 0x11,                               //   Unit (cm)
    0x55, 0x09,                               //   Unit Exponent (-7)
    0x95, 0x03,                               //   Report Count (3)
    0x09, 0x04,      0x09, 0x05, 0x09, 0x06,  // Usages (4, 5, 6: position x, y, z)
    0x81, 0x02,                               //   Input (Data, Variable, Absolute)
    0x85, kOutputId,                          //   Report ID (2)
    0x15, 0x00,                               //   Logical Minimum (0)
    0x27, 0xFF,      0xFF, 0xFF, 0xFF,        //   Logical Maximum (2^32 - 1)
    0x65, 0x00,                               //   Unit (none)
    0x55, 0x00,                               //   Unit Exponent (0)
    0x95, 0x01,                               //   Report Count (1)
    0x09, 0x02,                               //   Usage (2: sequence)
    0x91, 0x02,                               //   Output (Data, Variable, Absolute)
    0x17, 0x00,      0x00, 0x00, 0x80,        //   Logical Minimum (-2^31)
    0x27, 0xFF,      0xFF, 0xFF, 0x7F,        //   Logical Maximum (2^31 - 1)
    0x66, 0x11,      0xE1,                    //   Unit (g cm / s^2)
    0x55, 0x0F,                               //   Unit Exponent (-1)
    0x95, 0x03,                               //   Report Count (3)
    0x09, 0x07,      0x09, 0x08, 0x09, 0x09,  // Usages (7, 8, 9: force x, y, z)
    0x91, 0x02,                               //   Output (Data, Variable, Absolute)
    0xC0,                                     // End Collection
};

/// Reads little endian words after the id byte, by shifts, so that the byte order of the host does not matter.
std::uint32_t word(std::span<const std::byte> report, std::size_t index) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(report[1 + 4 * index + i]) << (8 * i);
  return value;
}

void set_word(std::span<std::byte> report, std::size_t index, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) report[1 + 4 * index + i] = static_cast<std::byte>(value >> (8 * i) & 0xFF);
}

bool is_report(std::span<const std::byte> report, std::uint8_t id, std::size_t size) {
  return report.size() >= size && report[0] == std::byte{id};
}

/// The product is rounded to a double before it is rounded to a whole number; since |x| < 2^31, that is an error of at most
/// 2^-22 of a unit.
std::int32_t saturated(double value, double units_per_one) {
  assert(!std::isnan(value));
  using Limits = std::numeric_limits<std::int32_t>;
  return static_cast<std::int32_t>(std::clamp<double>(std::round(value * units_per_one), Limits::min(), Limits::max()));
}

std::array<std::int32_t, 3> saturated(const glm::dvec3& value, double units_per_one) {
  return {saturated(value.x, units_per_one), saturated(value.y, units_per_one), saturated(value.z, units_per_one)};
}

}  // namespace

std::span<const std::byte> report_descriptor() { return std::as_bytes(std::span(kDescriptor)); }

std::optional<InputReport> decode_input(std::span<const std::byte> report) {
  if (!is_report(report, kInputId, kInputSize)) return std::nullopt;
  InputReport decoded{word(report, 0), word(report, 1), {}};
  for (std::size_t axis = 0; axis < 3; ++axis) decoded.position_nm[axis] = static_cast<std::int32_t>(word(report, 2 + axis));
  return decoded;
}

std::optional<OutputReport> decode_output(std::span<const std::byte> report) {
  if (!is_report(report, kOutputId, kOutputSize)) return std::nullopt;
  OutputReport decoded{word(report, 0), {}};
  for (std::size_t axis = 0; axis < 3; ++axis) decoded.force_uN[axis] = static_cast<std::int32_t>(word(report, 1 + axis));
  return decoded;
}

std::array<std::byte, kInputSize> encode(const InputReport& report) {
  std::array<std::byte, kInputSize> bytes{std::byte{kInputId}};
  set_word(bytes, 0, report.sequence);
  set_word(bytes, 1, report.device_time_us);
  for (std::size_t axis = 0; axis < 3; ++axis)
    set_word(bytes, 2 + axis, static_cast<std::uint32_t>(report.position_nm[axis]));
  return bytes;
}

std::array<std::byte, kOutputSize> encode(const OutputReport& report) {
  std::array<std::byte, kOutputSize> bytes{std::byte{kOutputId}};
  set_word(bytes, 0, report.sequence);
  for (std::size_t axis = 0; axis < 3; ++axis) set_word(bytes, 1 + axis, static_cast<std::uint32_t>(report.force_uN[axis]));
  return bytes;
}

std::array<std::int32_t, 3> to_nm(const glm::dvec3& position_m) { return saturated(position_m, 1e9); }
std::array<std::int32_t, 3> to_uN(const glm::dvec3& force_N) { return saturated(force_N, 1e6); }

}  // namespace evenstep::reference_device
