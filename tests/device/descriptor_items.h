#pragma once
// Writes report descriptors for tests, item by item.
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <vector>

namespace evenstep::test {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

/// The prefixes of items, with size bits 0.
enum ItemTag : int {
  kInput = 0x80,
  kOutput = 0x90,
  kFeature = 0xB0,
  kCollection = 0xA0,
  kEndCollection = 0xC0,
  kUsagePage = 0x04,
  kLogicalMinimum = 0x14,
  kLogicalMaximum = 0x24,
  kPhysicalMinimum = 0x34,
  kPhysicalMaximum = 0x44,
  kUnitExponent = 0x54,
  kUnit = 0x64,
  kReportSize = 0x74,
  kReportId = 0x84,
  kReportCount = 0x94,
  kPush = 0xA4,
  kPop = 0xB4,
  kUsage = 0x08,
  kUsageMinimum = 0x18,
  kUsageMaximum = 0x28,
  kDelimiter = 0xA8,
};

/// Appends an item with its data in `size` bytes: 0, 1, 2 or 4.
inline void add(Bytes& bytes, int tag, std::int64_t value, int size) {
  bytes.push_back(static_cast<std::byte>(tag | (size == 4 ? 3 : size)));
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

/// The number of bytes that a signed number needs.
inline int signed_size(std::int64_t value) {
  return value >= -128 && value < 128 ? 1 : value >= -32768 && value < 32768 ? 2 : 4;
}
inline int unsigned_size(std::int64_t value) { return value < 256 ? 1 : value < 65536 ? 2 : 4; }

}  // namespace evenstep::test
