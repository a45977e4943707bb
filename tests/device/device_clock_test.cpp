
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>

#include "cases.h"
#include "catch.h"
#include "evenstep/device/device_clock.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// A device that reports at `rate_Hz` by its own clock, over a cable that delays the reports.
struct Device {
  double rate_Hz = 1000;
  double ppm = 0, ppm_per_s = 0;  // how much its clock gains
  std::int64_t least_age_ns = 0;  // the least age of every report
  std::int64_t jitter_ns = 0;     // up to this much is added, uniformly
  double lost = 0;                // the share of reports that are lost
  std::int64_t quantum_us = 1;    // stamps are multiples of this
  std::uint32_t first_stamp_us = 0;
  std::int64_t tick_ns = 0;  // reports are read at multiples of it; 0: when they come
};

struct Seen {
  std::int64_t reports = 0;
  double worst_ns = 0;  // the largest difference between the time that was found and the true one, from `judged_s` on
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
  std::int64_t stamp_before_us = 0, ahead_before = 0;
  for (std::int64_t k = 0;; ++k) {
    const double device_s = static_cast<double>(k) / device.rate_Hz;
    // The host's time at which the device's clock says `device_s`: that clock runs at 1 + ppm + ppm_per_s t.
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
    const RealTime taken = clock.taken(device.first_stamp_us + static_cast<std::uint32_t>(stamp_us), RealTime{read_ns});
    ++seen.reports;
    REQUIRE(taken <= RealTime{read_ns});
    if (before) REQUIRE(taken >= *before);
    // Only a report from the future moves the times suddenly. Otherwise two reports are as far apart as their stamps, except
    // for the difference of the clocks and a few ms in half a second.
    const std::int64_t apart_ns = (stamp_us - stamp_before_us) * kUs;
    if (before && clock.ages().ahead == ahead_before)
      REQUIRE(std::abs((taken - *before).ns - apart_ns) <= apart_ns / 50 + 10);
    before = taken;
    stamp_before_us = stamp_us;
    ahead_before = clock.ages().ahead;
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

TEST_CASE("of 100 random devices the age above the least is known to a few reports' worth of their jitter") {
  std::mt19937_64 random(7);
  const auto between = [&](double least, double most) {
    return least + (most - least) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int trial = 0; trial < 100; ++trial) {
    Device device{.rate_Hz = between(125, 2000),
                  .ppm = between(-500, 500),
                  .ppm_per_s = between(-0.01, 0.01),
                  .least_age_ns = static_cast<std::int64_t>(between(0, 5e6)),
                  .lost = between(0, 0.2),
                  .first_stamp_us = static_cast<std::uint32_t>(random())};
    device.jitter_ns = static_cast<std::int64_t>(between(0, 2e9 / device.rate_Hz));
    const Seen seen = follow(device, 15, 4, random());
    // The least of the n jitters of a block is within J x / n of 0, except for a share e^-x of the blocks. A line through
    // such points that is continued by half its length and a block doubles their errors. A stamp is off by a microsecond,
    // and the least one of a block by another.
    const double reports = device.rate_Hz * (1 - device.lost) / 2;
    const double bound_ns = 2 * 20 * static_cast<double>(device.jitter_ns) / reports + 3000;
    CAPTURE(trial, seen.ages.restarts, seen.ages.capped, device.rate_Hz, device.ppm, device.jitter_ns, device.lost,
            seen.earliest_ns, seen.latest_ns);
    REQUIRE(seen.worst_ns <= bound_ns);
    // The line lies below the least reports of thirty blocks, which never all lie on it. Above them nothing would be left.
    REQUIRE(seen.ages.residual > Duration{0});
    REQUIRE((seen.ages.restarts == 0 && seen.ages.capped == 0));
    REQUIRE(std::abs(*seen.ages.clock_rate_error * 1e6 - device.ppm) <= 0.5 + bound_ns / 5e3);
  }
}

TEST_CASE("a clock is followed up to a difference of 1 %, and one that differs by more is taken to differ by that") {
  CHECK(std::abs(follow({.ppm = 9'000}, 20, 10, 1).ages.clock_rate_error.value()) == Approx(0.009).epsilon(0.02));
  CHECK(std::abs(follow({.ppm = 20'000}, 20, 10, 1).ages.clock_rate_error.value()) == Approx(0.01).epsilon(1e-6));
}

TEST_CASE("a clock whose rate drifts is followed to drift times the square of the window over 8") {
  for (const double ppm_per_s : {-0.1, 0.1}) {
    const Seen seen = follow({.ppm = 20, .ppm_per_s = ppm_per_s, .jitter_ns = 200 * kUs}, 100, 70, 3);
    CHECK(seen.worst_ns <= 0.1e-6 * 64 * 64 / 8 * 1e9 * 1.25);  // a quarter more: the line is up to two blocks old
  }
}

TEST_CASE("reports seen at ticks of their own period: off by up to a period, and by a twentieth after three slips") {
  for (const double ppm : {-500.0, -100.0, 100.0, 200.0, 500.0}) {
    const double slip_s = 1e3 / std::abs(ppm);
    const Device device{.ppm = ppm, .jitter_ns = 200 * kUs, .tick_ns = kMs};
    CHECK(follow(device, 3 * slip_s, 1, 5).worst_ns <= 1.3e6);  // more than a period while the first line is too steep
    CHECK(follow(device, 70, 50, 5).worst_ns <= 0.05e6);
  }
}

TEST_CASE("stamps in milliseconds leave at most a millisecond") {
  const Seen seen = follow({.rate_Hz = 700, .ppm = 50, .jitter_ns = 200 * kUs, .quantum_us = 1000}, 20, 4, 1);
  CHECK((seen.earliest_ns >= -1.02e6 && seen.latest_ns <= 0.02e6));
  CHECK(seen.ages.capped == 0);
}

TEST_CASE("a report may be as late as it likes: the others keep their times, and it has its own") {
  DeviceClock clock;
  for (std::uint32_t k = 0; k < 5000; ++k) {
    const bool late = k % 100 == 99;
    const RealTime taken{k * kMs};
    REQUIRE(clock.taken(k * 1000, taken + Duration{late ? 999 * kUs : 0}) == taken);
  }
  CHECK((clock.ages().ahead == 0 && clock.ages().capped == 0 && clock.ages().residual == Duration{0}));
}

TEST_CASE("a clock that was set is followed anew, and what was moved is counted") {
  DeviceClock clock;
  const auto at = [&](double device_ms, double read_ms) {
    const RealTime read{static_cast<std::int64_t>(read_ms * 1e6)};
    return (clock.taken(static_cast<std::uint32_t>(device_ms * 1000), read) - RealTime{0}).ns / 1e6;
  };
  for (int k = 0; k < 100; ++k) at(k, k);
  CHECK(at(100.04, 100) == 100);  // 40 us from the future: the line moves down to it
  CHECK((clock.ages().ahead == 1 && clock.ages().ahead_max == Duration{40 * kUs}));
  CHECK(at(101, 101) == Approx(100.96));
  CHECK(at(160, 102) == 102);  // 58 ms from the future
  CHECK(clock.ages().restarts == 1);
  CHECK(at(150, 103) == 103);  // the clock is set back
  CHECK(clock.ages().restarts == 2);

  CHECK(at(151, 2000) == 1000);  // at most a second old
  CHECK(clock.ages().capped == 1);
  CHECK(at(151, 2001) == Approx(1001));
  // From now on the clock is 200 ms behind. At first these reports count as old. At the end of their block the clock is
  // followed again from the start.
  clock.restart();
  for (int k = 0; k < 600; ++k) at(200 + k, 3000 + k);
  CHECK(at(800, 3800) == Approx(3600));
  for (int k = 1; k < 1000; ++k) at(800 + k, 3800 + k);
  CHECK(at(1801, 4801) == 4801);
  CHECK(clock.ages().restarts == 4);

  clock.passed_on(RealTime{5}, RealTime{9});
  CHECK((clock.ages().ages.count() == 1 && clock.ages().ages.largest() == Duration{4}));
}

TEST_CASE("after a restart a clock is followed as one that nobody has followed before, by 500 random devices and pasts") {
  // Times do not decrease: as long as those from before the restart are ahead, each is 1 ns after the one before, or the
  // read.
  std::int64_t held = 0, judged = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(500); ++seed) {
    std::mt19937_64 random(seed);
    DeviceClock old, fresh;
    RealTime read, before{-10 * kSecond};
    auto stamp = static_cast<std::uint32_t>(random());
    for (std::uint64_t k = random() % 3000; k > 0; --k) {
      read = read + Duration{static_cast<std::int64_t>(random() % 2'000'000)};
      stamp += static_cast<std::uint32_t>(random() % (random() % 500 == 0 ? 1'000'000'000 : 2000));
      before = old.taken(stamp, read);
    }
    const bool told = random() % 2 == 0;
    if (told) old.restart();
    stamp = told ? static_cast<std::uint32_t>(random()) : stamp - 1 - static_cast<std::uint32_t>(random() % 1'000'000);
    const std::int64_t jitter_ns = static_cast<std::int64_t>(random() % 5'000'000) + 1;
    const auto begun = read;
    for (std::int64_t k = 0; k < 3000; ++k, ++judged) {
      const RealTime due =
          begun + Duration{k * kMs + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(jitter_ns))};
      read = std::max(read, due);
      const RealTime with = old.taken(stamp, read), without = fresh.taken(stamp, read);
      INFO("seed " << seed << ", report " << k);
      if (with != without) {
        ++held;
        REQUIRE((with > without && with == std::min(before + Duration{1}, read)));
      }
      before = with;
      stamp += 1000;
    }
    REQUIRE(old.ages().clock_rate_error == fresh.ages().clock_rate_error);
    REQUIRE(old.ages().residual == fresh.ages().residual);
  }
  CHECK(judged > 100 * held);
}

TEST_CASE("the least age is subtracted where it is known") {
  DeviceClock clock(Duration{300 * kUs});
  for (std::uint32_t k = 1; k < 1000; ++k)
    REQUIRE(clock.taken(k * 1000, RealTime{k * kMs}) == RealTime{k * kMs - 300 * kUs});
}

TEST_CASE(
    "whatever a device stamps, its times do not decrease, are not from the future, and overflow nothing, 200,000 times") {
  std::mt19937_64 random(11);
  DeviceClock clock;
  RealTime read, before{-10 * kSecond};
  std::uint32_t stamp = 0;
  for (int k = 0; k < 200'000; ++k) {
    read = read + Duration{static_cast<std::int64_t>(random() % (random() % 50 == 0 ? 3'000'000'000 : 2'000'000))};
    stamp += random() % 20 == 0 ? static_cast<std::uint32_t>(random()) : static_cast<std::uint32_t>(random() % 2000);
    const RealTime taken = clock.taken(stamp, read);
    REQUIRE((taken <= read && taken >= before && read - taken <= Duration{kSecond}));
    before = taken;
    if (random() % 5000 == 0) clock.restart();
  }
}
