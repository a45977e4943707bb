#pragma once
// CRC-32C (Castagnoli: polynomial 0x1EDC6F41, here reflected, as in RFC 3720, appendix B.4). Own code, because it is ten
// lines, and zlib, which has another polynomial, is not linked.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace evenstep::internal {

inline constexpr std::array<std::uint32_t, 256> kCrc32cTable = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0x82F63B78U : 0U);
    table[byte] = crc;
  }
  return table;
}();

inline std::uint32_t crc32c(std::span<const std::byte> bytes) {
  std::uint32_t crc = ~0U;
  for (const std::byte byte : bytes) crc = kCrc32cTable[(crc ^ static_cast<std::uint32_t>(byte)) & 0xFFU] ^ (crc >> 8);
  return ~crc;
}

}  // namespace evenstep::internal
