#pragma once
/// evenstep's times made from those of std::chrono, for programs that use the remap with a clock of their own:
///
///   using namespace std::chrono_literals;
///   evenstep::duration(15ms + 66us)                                    15,066,000 ns
///   const auto start = std::chrono::steady_clock::now();               once, before the threads begin
///   evenstep::real_time(std::chrono::steady_clock::now() - start)      now, on every thread
///
/// Everything is converted exactly. A length that is not a whole number of nanoseconds (chrono's with double) does not
/// compile: round it first (std::chrono::round). Range: that of time.h.

#include <chrono>

#include "evenstep/time/time.h"

namespace evenstep {

constexpr Duration duration(std::chrono::nanoseconds length) { return {length.count()}; }

/// The instant `since_start` after the program's start. The clock must be steady: a wall clock is set back at times.
constexpr RealTime real_time(std::chrono::nanoseconds since_start) { return {since_start.count()}; }

}  // namespace evenstep
