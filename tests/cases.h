#pragma once
/// How many cases of a property a test tries.

#include <cstdint>

namespace evenstep::testing {

/// Sanitized builds try a tenth: they check memory and arithmetic, not the property, take up to ten times as long for each
/// case, and see the same paths in fewer of them.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::uint64_t kShare = 10;
#else
constexpr std::uint64_t kShare = 1;
#endif

/// `count` of them, or in a sanitized build the share of it, rounded up.
constexpr std::uint64_t cases(std::uint64_t count) { return (count + kShare - 1) / kShare; }

}  // namespace evenstep::testing
