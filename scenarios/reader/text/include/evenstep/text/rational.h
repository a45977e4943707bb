#pragma once
/// Makes exact rates from 128-bit products.

#include "evenstep/time/time.h"

namespace evenstep::internal {

constexpr __int128 greatest_common_divisor(__int128 a, __int128 b) {
  while (b != 0) {
    const __int128 rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/// den * 1e9 must fit int64 (evenstep::first_tick_at_or_after).
inline constexpr std::int64_t kMostRateDen = 9'000'000'000;

/// num / den in lowest terms; num, den > 0, 1 / kMostRateDen <= num / den < 2^63. If den is still above kMostRateDen, the
/// result is the last convergent of the continued fraction whose denominator is at most that: |num/den - p/q| < 1 / (q *
/// kMostRateDen). At 450 steps per second the instants of a recording then move by less than a nanosecond in an hour (1 /
/// (450 * 9e9) of the run time); recordings under 9 s stay exact.
Rate reduced_rate(__int128 num, __int128 den);

}  // namespace evenstep::internal
