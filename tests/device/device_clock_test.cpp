#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include "evenstep/device/device_clock.h"

using namespace evenstep;

namespace {

constexpr std::int64_t kUs = 1'000, kMs = 1'000'000, kSecond = 1'000'000'000;

/// A device that reports at `rate_Hz` by a clock of its own, and a cable that is late.
struct Device {
  double rate_Hz = 1000;
  double ppm = 0, ppm_per_s = 0;         // its clock gains so much
  std::int64_t least_age_ns = 0;         // of every report
  std::int64_t jitter_ns = 0;            // one-sided, uniform, on top
  double lost = 0;                       // share of the reports
  std::int64_t quantum_us = 1;           // of its stamps
  std::uint32_t first_stamp_us = 0;
  std::int64_t tick_ns = 0;              // reports are read at multiples of it; 0: when they come
};

struct Seen {
  std::int64_t reports = 0;
  double worst_ns = 0;  // |taken - when it was taken| after `judged_from`
  double earliest_ns = 0, latest_ns = 0;
  SampleAges ages;
};

/// Runs for `length_s` and compares from `judged_s` on.
Seen follow(const Device& device, double length_s, double judged_s, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  DeviceClock clock({device.least_age_ns});
  Seen seen;
  std::int64_t arrival_before = 0;
  std::optional<RealTime> before;
  for (std::int64_t k = 0;; ++k) {
    const double device_s = static_cast<double>(k) / device.rate_Hz;
    // The host's time at which its clock says so: its rate is 1 + ppm + ppm_per_s t.
    const double gain = (device.ppm + device.ppm_per_s * device_s / 2) * 1e-6;
    const double host_s = device_s / (1 + gain);
    if (host_s > length_s) break;
    const std::int64_t taken_ns = std::llround(host_s * 1e9) + 3 * kSecond;
    const auto wait_ns = static_cast<std::int64_t>(uniform() * static_cast<double>(device.jitter_ns));
    std::int64_t read_ns = std::max(arrival_before, taken_ns + device.least_age_ns + wait_ns);
    arrival_before = read_ns;
    if (device.tick_ns > 0) read_ns = (read_ns + device.tick_ns - 1) / device.tick_ns * device.tick_ns;
    if (uniform() < device.lost) continue;
    const auto stamp_us = static_cast<std::int64_t>(device_s * 1e6 + 1e-6) / device.quantum_us * device.quantum_us;
    const RealTime taken =
        clock.taken(device.first_stamp_us + static_cast<std::uint32_t>(stamp_us), RealTime{read_ns});
    ++seen.reports;
    REQUIRE(taken <= RealTime{read_ns});
    if (before) REQUIRE(taken >= *before);
    before = taken;
    if (device_s < judged_s) continue;
    const auto off_ns = static_cast<double>(taken.ns - taken_ns);
    seen.earliest_ns = std::min(seen.earliest_ns, off_ns);
    seen.latest_ns = std::max(seen.latest_ns, off_ns);
    seen.worst_ns = std::max(std::abs(off_ns), seen.worst_ns);
  }
  seen.ages = clock.ages();
  return seen;
}

}  // namespace

TEST_CASE("on one clock, and with one age, a sample's time is exact to the stamp's microsecond, over the wrap-around too") {
  for (const std::int64_t age_ns : {std::int64_t{0}, kMs / 3, 5 * kMs}) {
    for (const std::uint32_t first : {0U, 0xFFFFFFFFU - 3'000'000U, 0x7FFFFFFFU}) {
      const Seen seen = follow({.least_age_ns = age_ns, .first_stamp_us = first}, 10, 0, 1);
      CHECK(seen.worst_ns <= 1);
      CHECK((seen.ages.capped == 0 && seen.ages.restarts == 0));
    }
  }
}

TEST_CASE("print", "[.print]") {
  for (double ppm : {-500., -100., -50., -20., 0., 5., 20., 50., 100., 200., 500.}) {
    for (std::int64_t tick : {std::int64_t{0}, kMs}) {
      for (std::int64_t jitter : {std::int64_t{0}, 300 * kUs, 2 * kMs}) {
        const Seen seen = follow({.ppm = ppm, .jitter_ns = jitter, .tick_ns = tick}, 200, 100, 1);
        std::printf("ppm %6.0f tick %7ld jitter %7ld: %8.1f .. %8.1f us, ahead %ld max %.1f us restarts %ld, rate %.2f ppm, residual %.1f us\n", ppm, tick, jitter,
                    seen.earliest_ns / 1e3, seen.latest_ns / 1e3, seen.ages.ahead, static_cast<double>(seen.ages.ahead_max.ns) / 1e3, seen.ages.restarts, seen.ages.clock_rate_error * 1e6, static_cast<double>(seen.ages.residual.ns) / 1e3);
      }
    }
  }
}
