#pragma once
/// 64-bit digests for the trace hash: a chain h' = mix(h, word). This is our own code because it runs for every event in
/// the core (it costs two multiplications) and because its value is part of the contract: it must never change with the
/// version of a library. Not cryptographic.

#include <bit>
#include <cstdint>
#include <string_view>

namespace evenstep {

/// murmur3's 64-bit finaliser (public domain constants): a bijection that spreads every input bit.
constexpr std::uint64_t spread(std::uint64_t h) {
  h ^= h >> 33;
  h *= 0xff51afd7ed558ccdULL;
  h ^= h >> 33;
  h *= 0xc4ceb9fe1a85ec53ULL;
  h ^= h >> 33;
  return h;
}
constexpr std::uint64_t mix(std::uint64_t h, std::uint64_t word) {
  return spread(h * 0x9e3779b97f4a7c15ULL + spread(word + 0x2545f4914f6cdd1dULL));
}
/// Compares bit for bit: -0.0 and 0.0 differ, as they must in a hash that is used to find the first difference.
constexpr std::uint64_t mix(std::uint64_t h, double value) { return mix(h, std::bit_cast<std::uint64_t>(value)); }

/// FNV-1a of a name (names are short, so its speed does not matter).
constexpr std::uint64_t name_digest(std::string_view name) {
  std::uint64_t h = 0xcbf29ce484222325ULL;
  for (char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return h;
}

}  // namespace evenstep
