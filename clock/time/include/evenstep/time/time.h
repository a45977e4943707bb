#pragma once
/// Time as evenstep uses it: three 64-bit integer nanosecond types that do not mix.
///
/// The fault this project exists to mend is the confusion of real time with simulation time (paper, section 2), so the
/// two are different types: `RealTime - SimTime`, `SimTime + Duration` and every implicit conversion are compile errors
/// (tests/compile_fail). Neither 1/30 s nor 1/450 s is a whole number of nanoseconds. The instants of a rational rate are
/// therefore floors of the exact rational (`tick_time`), never sums of a rounded period, so they do not drift.
///
/// Range: +-292 years. Overflow is a programming error and not checked here; readers of user input limit values to 1e6 s.

#include <compare>
#include <cstdint>

namespace evenstep {

/// A length of real time, ns.
struct Duration {
  std::int64_t ns = 0;
  friend constexpr auto operator<=>(Duration, Duration) = default;
  friend constexpr Duration operator+(Duration a, Duration b) { return {a.ns + b.ns}; }
  friend constexpr Duration operator-(Duration a, Duration b) { return {a.ns - b.ns}; }
  friend constexpr Duration operator-(Duration a) { return {-a.ns}; }
  friend constexpr Duration operator*(Duration a, std::int64_t factor) { return {a.ns * factor}; }
  constexpr Duration& operator+=(Duration b) {
    ns += b.ns;
    return *this;
  }
};

/// An instant of real time, ns since the start of the run (virtual or wall): the time in which the user's hand moves.
struct RealTime {
  std::int64_t ns = 0;
  friend constexpr auto operator<=>(RealTime, RealTime) = default;
  friend constexpr RealTime operator+(RealTime t, Duration d) { return {t.ns + d.ns}; }
  friend constexpr RealTime operator-(RealTime t, Duration d) { return {t.ns - d.ns}; }
  friend constexpr Duration operator-(RealTime a, RealTime b) { return {a.ns - b.ns}; }
};

/// From an instant to another one that is not before it.
struct Interval {
  RealTime begin;
  RealTime end;
};

/// An instant of simulation time, ns since step 0: the time of the physics. It is made from a step index (`sim_time`), or
/// from the lengths of the steps if these follow real time.
struct SimTime {
  std::int64_t ns = 0;
  friend constexpr auto operator<=>(SimTime, SimTime) = default;
};

inline constexpr RealTime kNever{INT64_MAX};

/// Events per second as an exact rational, both parts positive. 450 Hz = {450, 1}; "1/3 Hz" = {1, 3}.
struct Rate {
  std::int64_t num = 1;
  std::int64_t den = 1;
  friend constexpr bool operator==(Rate, Rate) = default;
};

/// floor(a * b / c) for c > 0 with a 128-bit intermediate.
constexpr std::int64_t floor_mul_div(std::int64_t a, std::int64_t b, std::int64_t c) {
  const __int128 product = static_cast<__int128>(a) * b;
  __int128 quotient = product / c;
  if (product % c < 0) --quotient;
  return static_cast<std::int64_t>(quotient);
}

/// floor(k * den * 1e9 / num) ns: instant k of a rate, exact for every k (k may be negative).
constexpr std::int64_t instant_ns(Rate rate, std::int64_t k) {
  const __int128 product = static_cast<__int128>(k) * rate.den * 1'000'000'000;
  __int128 quotient = product / rate.num;
  if (product % rate.num < 0) --quotient;
  return static_cast<std::int64_t>(quotient);
}

/// Tick k of a rate whose tick 0 is at `origin`.
constexpr RealTime tick_time(Rate rate, std::int64_t k, RealTime origin = {}) { return {origin.ns + instant_ns(rate, k)}; }

/// The first k with tick_time(rate, k, origin) >= at.
constexpr std::int64_t first_tick_at_or_after(Rate rate, RealTime at, RealTime origin = {}) {
  std::int64_t k = floor_mul_div(at.ns - origin.ns, rate.num, rate.den * 1'000'000'000);
  while (tick_time(rate, k, origin) < at) ++k;
  return k;
}

/// Simulation time of step n when the solver makes `step_rate` steps per simulated second.
constexpr SimTime sim_time(Rate step_rate, std::int64_t n) { return {instant_ns(step_rate, n)}; }

/// The longest time between two neighbouring ticks: ceil(den * 1e9 / num) ns.
constexpr Duration period_ceil(Rate rate) { return {-instant_ns({rate.num, rate.den}, -1)}; }

// A division, not a multiplication by 1e-9: it gives the double nearest to the decimal number, the one that parsing
// "12.842223 ms" gives as well.
constexpr double seconds(Duration d) { return static_cast<double>(d.ns) / 1e9; }
constexpr double seconds(RealTime t) { return static_cast<double>(t.ns) / 1e9; }
constexpr double seconds(SimTime t) { return static_cast<double>(t.ns) / 1e9; }
/// Period of a rate in seconds (the solver's step size; a number for arithmetic, not an instant).
constexpr double period_s(Rate rate) { return static_cast<double>(rate.den) / static_cast<double>(rate.num); }

/// When one step really ran. `index` counts from 0 within the segment.
struct StepTimes {
  RealTime begin;
  RealTime end;
  std::int64_t segment = 0;
  std::int32_t index = 0;
};

}  // namespace evenstep
