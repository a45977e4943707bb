#pragma once
/// Numbers that many of these tests use.

#include <cstdint>
#include <limits>

namespace evenstep::test {

constexpr std::int64_t kUs = 1'000, kMs = 1'000'000, kSecond = 1'000'000'000;  // in nanoseconds
constexpr double kEpsilon = 0x1p-52, kInfinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t kTwo31 = std::int64_t{1} << 31;

}  // namespace evenstep::test
