#pragma once
/// The reference device: our own report layout (docs/devices/reference-device.md), shared by driver and simulation.
///
/// Input report 1 (21 bytes):   u8 id = 1 | u32 sequence | u32 device time, us | i32 x, y, z, nm     little endian
/// Output report 2 (17 bytes):  u8 id = 2 | u32 sequence | i32 fx, fy, fz, uN
/// Both sequence numbers count sent reports from 1, modulo 2^32. The time counts from the start, modulo 2^32 us (71.6
/// minutes). Positions of 16 bits would cause errors of 3 % of a step; int32 nm spans +-2.1 m.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <glm/vec3.hpp>

namespace evenstep::reference_device {

inline constexpr std::uint16_t kVendorId = 0x1209;
inline constexpr std::uint16_t kProductId = 0x0E57;
inline constexpr std::size_t kInputSize = 21;
inline constexpr std::size_t kOutputSize = 17;

std::span<const std::byte> report_descriptor();

struct InputReport {
  std::uint32_t sequence = 0;
  std::uint32_t device_time_us = 0;
  std::array<std::int32_t, 3> position_nm{};
};
struct OutputReport {
  std::uint32_t sequence = 0;
  std::array<std::int32_t, 3> force_uN{};
};
/// Empty for a wrong id or length. A longer report is accepted and its tail ignored, because the kernel delivers it whole.
std::optional<InputReport> decode_input(std::span<const std::byte> report);
std::optional<OutputReport> decode_output(std::span<const std::byte> report);
std::array<std::byte, kInputSize> encode(const InputReport& report);
std::array<std::byte, kOutputSize> encode(const OutputReport& report);

/// Rounded to the nearest unit (ties away from zero) and limited to the range of int32. NaN is a programming error.
std::array<std::int32_t, 3> to_nm(const glm::dvec3& position_m);
std::array<std::int32_t, 3> to_uN(const glm::dvec3& force_N);

}  // namespace evenstep::reference_device
