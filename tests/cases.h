#pragma once
/// How many cases of a property a test tries.

#include <concepts>
#include <cstdint>

namespace evenstep::testing {

/// Sanitized builds try only a twentieth of the cases. They check memory and arithmetic, not the property; they take up to
/// ten times as long for each case, and see the same paths with fewer cases.
#if defined(EVENSTEP_SANITIZE_ADDRESS) || defined(EVENSTEP_SANITIZE_THREAD)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr int kShare = kSanitized ? 20 : 1;

/// `count` cases, or in a sanitized build the share of them, rounded up.
constexpr std::uint64_t share_of(std::uint64_t count) { return (count + kShare - 1) / kShare; }
template <std::integral Count>
consteval Count cases(Count count) {
  return static_cast<Count>(share_of(static_cast<std::uint64_t>(count)));
}
static_assert(cases(1) == 1);  // g++ 14 takes the first call in a source for a variable, and warns of its sign

}  // namespace evenstep::testing
