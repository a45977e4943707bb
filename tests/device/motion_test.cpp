
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "catch.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/motion.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr long double kLongPi = 3.14159265358979323846264338327950288L;

const glm::dvec3 kVelocity{0.1, -0.25, 0};
const std::array<Duration, 5> kStarts{Duration{0}, Duration{1}, Duration{7 * kMs + 1}, Duration{100 * kMs},
                                      Duration{2 * kSecond}};

double x_m(const Motion& motion, std::int64_t ns) { return position_m(motion, RealTime{ns}).x; }

}  // namespace

TEST_CASE("constant velocity follows its closed form on both sides of the start's end") {
  for (const Duration start : kStarts) {
    const ConstantVelocity motion{kVelocity, start, {0.5, 0.5, 0.5}};
    for (std::int64_t k = 0; k <= 3000; ++k) {
      const std::int64_t ns = start.ns < 1000 ? k : start.ns / 1000 * k;
      const long double t = ns / 1e9L;
      const long double t_s = start.ns / 1e9L;
      const long double u = start.ns > 0 ? t / t_s : 1;
      const long double run = ns >= start.ns ? t - t_s / 2 : t_s * (u * u * u - u * u * u * u / 2);
      for (int axis = 0; axis < 3; ++axis) {
        const long double expected = 0.5L + kVelocity[axis] * run;
        // At most seven roundings, each by 2^-53 of a value below 2.
        CHECK(std::abs(position_m(motion, RealTime{ns})[axis] - expected) <= 14 * 0x1p-53L);
      }
    }
    CHECK(x_m(ConstantVelocity{{0.1, 0, 0}, start}, start.ns) == 0.1 * (static_cast<double>(start.ns) / 2e9));
  }
}

TEST_CASE("the smooth start has no jump in velocity or acceleration") {
  // The second difference of a C2 curve is h^2 x'' + O(h^3). Between two neighbours it changes by at most h^3 max |x'''|,
  // where x''' = v (6 - 12 u) / t_s^2. A jump of the acceleration (v 3 / t_s for a parabola of that height) would change it
  // by h^2 1.5 v / t_s, which is 25 times the bound here.
  const double v = 0.1, t_s = 0.1, h = 1e-3;
  const ConstantVelocity motion{{v, 0, 0}, Duration{100 * kMs}};
  const auto second_difference = [&](std::int64_t ns) {
    return x_m(motion, ns + kMs) - 2 * x_m(motion, ns) + x_m(motion, ns - kMs);
  };
  const double rounding = 8 * 0x1p-53 * 0.02;
  for (std::int64_t ns = -5 * kMs; ns <= 200 * kMs; ns += kMs / 4) {
    CHECK(std::abs(second_difference(ns + kMs) - second_difference(ns)) <= h * h * h * 6 * v / (t_s * t_s) + rounding);
  }
}

TEST_CASE("at 0.1 m/s every millisecond after the start is a whole number of nanometres") {
  for (const std::int64_t start_ms : {0, 2, 50, 100, 250, 1000}) {
    const ConstantVelocity motion{{0.1, -0.1, 0}, Duration{start_ms * kMs}};
    for (std::int64_t ms = start_ms; ms <= 20'000; ++ms) {
      const std::int64_t nm = 100'000 * ms - 50'000 * start_ms;
      const glm::dvec3 position = position_m(motion, RealTime{ms * kMs});
      // Three roundings (0.1, the seconds, the product) of at most 2^-53 each, below 2.1 m: 7e-16 m.
      REQUIRE(std::abs(position.x - static_cast<long double>(nm) / 1e9L) <= 7e-16L);
      REQUIRE(reference_device::to_nm(position) ==
              std::array<std::int32_t, 3>{static_cast<std::int32_t>(nm), static_cast<std::int32_t>(-nm), 0});
    }
  }
}

namespace {
const std::array<Duration, 3> kTurns{Duration{7 * kMs + 1}, Duration{200 * kMs}, Duration{kSecond}};
const std::array<Duration, 3> kStraights{Duration{333 * kMs + 1}, Duration{2 * kSecond}, Duration{4 * kSecond}};
}  // namespace

TEST_CASE("back and forth is constant velocity until the first turn, bit for bit") {
  for (const Duration start : kStarts) {
    const ConstantVelocity straight{kVelocity, start, {0.5, 0.5, 0.5}};
    const BackAndForth motion{straight, Duration{2 * kSecond}, Duration{100 * kMs}};
    for (std::int64_t ns = -5 * kMs; ns <= start.ns + 2 * kSecond; ns += kMs / 3)
      REQUIRE(position_m(motion, RealTime{ns}) == position_m(straight, RealTime{ns}));
  }
}

TEST_CASE("back and forth covers the same points on every way, and in a turn 5/16 of its length at full speed beyond") {
  for (const Duration straight : kStraights) {
    for (const Duration turn : kTurns) {
      const BackAndForth motion{{kVelocity, Duration{100 * kMs}}, straight, turn};
      const std::int64_t period_ns = straight.ns + turn.ns;
      const double beyond_m = 5.0 / 16 * static_cast<double>(turn.ns) / 1e9 * 0.1, rounding = 4 * 0x1p-53;
      const double from_m = x_m(motion, 100 * kMs), to_m = x_m(motion, 100 * kMs + straight.ns);
      CHECK(to_m - from_m == Approx(0.1 * static_cast<double>(straight.ns) / 1e9).epsilon(1e-14));
      for (const std::int64_t way : {1, 2, 7, 100'000}) {  // the last one comes after up to six days
        const std::int64_t begin_ns = 100 * kMs + way * period_ns;
        for (std::int64_t k = 0; k <= 1000; ++k) {
          const std::int64_t into_ns = straight.ns / 1000 * k;
          const std::int64_t as_first = 100 * kMs + (way % 2 == 1 ? straight.ns - into_ns : into_ns);
          REQUIRE(x_m(motion, begin_ns + into_ns) == x_m(motion, as_first));
          const double turned_m = x_m(motion, begin_ns + straight.ns + turn.ns / 1000 * k);
          REQUIRE(turned_m <= to_m + beyond_m + rounding);
          REQUIRE(turned_m >= from_m - beyond_m - rounding);
        }
        const double at_peak_m = x_m(motion, begin_ns + straight.ns + turn.ns / 2);
        CHECK(at_peak_m == Approx(way % 2 == 1 ? from_m - beyond_m : to_m + beyond_m).margin(1e-9));
      }
    }
  }
}

TEST_CASE("a turn has no jump in velocity or acceleration") {
  // As for the smooth start: x''' of a turn is v (12 - 24 u) / turn^2 at most.
  const double v = 0.1, turn_s = 0.1, h = 1e-3;
  const BackAndForth motion{{{v, 0, 0}, Duration{100 * kMs}}, Duration{500 * kMs}, Duration{100 * kMs}};
  const auto second_difference = [&](std::int64_t ns) {
    return x_m(motion, ns + kMs) - 2 * x_m(motion, ns) + x_m(motion, ns - kMs);
  };
  const double rounding = 8 * 0x1p-53 * 0.1;
  for (std::int64_t ns = 0; ns <= 2000 * kMs; ns += kMs / 4)
    REQUIRE(std::abs(second_difference(ns + kMs) - second_difference(ns)) <=
            h * h * h * 12 * v / (turn_s * turn_s) + rounding);
}

TEST_CASE("at 0.1 m/s every millisecond on a straight piece is a whole number of nanometres, there and back") {
  const BackAndForth motion{{{0.1, -0.1, 0}, Duration{200 * kMs}}, Duration{4 * kSecond}, Duration{200 * kMs}};
  for (std::int64_t ms = 200; ms <= 60'000; ++ms) {
    const std::int64_t into = (ms - 200) % 4200, way = (ms - 200) / 4200;
    if (into > 4000) continue;
    const std::int64_t nm = 100'000 * (100 + (way % 2 == 1 ? 4000 - into : into));
    const glm::dvec3 position = position_m(motion, RealTime{ms * kMs});
    REQUIRE(std::abs(position.x - static_cast<long double>(nm) / 1e9L) <= 7e-16L);
    REQUIRE(reference_device::to_nm(position) ==
            std::array<std::int32_t, 3>{static_cast<std::int32_t>(nm), static_cast<std::int32_t>(-nm), 0});
  }
}

TEST_CASE("the sine follows (1 - cos) / 2 and mirrors bit for bit within a turn") {
  const std::array<Rate, 5> frequencies{Rate{1, 1}, Rate{30, 1}, Rate{3, 7}, Rate{1, 100}, Rate{450, 1}};
  for (const Rate frequency : frequencies) {
    const Sine motion{{0.02, 0, -1}, frequency};
    for (std::int64_t k = 0; k <= 10'000; ++k) {
      const std::int64_t ns = k * 1'234'567;
      // The phase is computed exactly first, because the reference must not lose digits in the turns either.
      const std::int64_t turn = frequency.den * kSecond;
      const long double phase = static_cast<long double>(ns * frequency.num % turn) / turn;
      const long double expected = (1 - std::cos(2 * kLongPi * phase)) / 2;
      // For sin(a)^2 the angle takes 3 roundings and the sine 4 ulp, and the square doubles both. At an amplitude of 1 that
      // is below 20 * 2^-53.
      REQUIRE(std::abs(position_m(motion, RealTime{ns}).z + expected) <= 20 * 0x1p-53L);
      if (ns < turn) REQUIRE(x_m(motion, ns) == x_m(motion, turn - ns));
    }
  }
}

TEST_CASE("the sine repeats bit for bit in a run of ten million seconds") {
  for (const Rate frequency : {Rate{1, 1}, Rate{30, 1}, Rate{3, 7}, Rate{450, 1}}) {
    const Sine motion{{0.02, 0.01, 0}, frequency};
    for (std::int64_t k = 1; k <= 1000; ++k) {
      const std::int64_t ns = 1 + k * 987'654'321;
      const std::int64_t whole_turns_later = ns + frequency.den * kSecond * (k * 10'000 / frequency.den);
      REQUIRE(position_m(motion, RealTime{ns}) == position_m(motion, RealTime{whole_turns_later}));
    }
  }
}

TEST_CASE("the sine is at rest at its start: it never cancels to noise near zero") {
  const Sine motion{{1, 0, 0}, Rate{1, 1}};
  for (std::int64_t ns = 1; ns < kSecond / 100; ns = ns * 3 / 2 + 1) {
    const long double angle = kLongPi * ns / 1e9L;
    const long double expected = std::sin(angle) * std::sin(angle);
    CHECK(std::abs(x_m(motion, ns) / expected - 1) <= 20 * 0x1p-53L);
  }
}

TEST_CASE("a ramp stop is its ramp until the stop and stands from then on") {
  const ConstantVelocity ramp{kVelocity, Duration{100 * kMs}, {0, 0, 0.1}};
  for (const std::int64_t stop : {-kMs, 0 * kMs, 50 * kMs, 100 * kMs, 777 * kMs}) {
    const RampStop motion{ramp, RealTime{stop}};
    for (std::int64_t ns = -2 * kMs; ns < 1000 * kMs; ns += kMs / 3) {
      REQUIRE(position_m(motion, RealTime{ns}) == position_m(ramp, RealTime{std::min(ns, stop)}));
    }
  }
}

TEST_CASE("a stick-slip motion holds, slips evenly to the mean line, and is on it at every period") {
  struct {
    Duration stick, slip;
  } const rows[] = {{{90 * kMs}, {10 * kMs}},   {{1}, {1}},       {{0}, {7}},          {{66'666'666}, {12'500'000}},
                    {{kSecond}, {333'333'333}}, {{3 * kMs}, {1}}, {{1}, {3 * kMs + 1}}};
  for (const auto& [stick, slip] : rows) {
    const StickSlip motion{kVelocity, stick, slip};
    const std::int64_t period = stick.ns + slip.ns;
    for (std::int64_t k = 0; k <= 4000; ++k) {
      const std::int64_t ns = period < 1000 ? k : period / 399 * k;
      const std::int64_t since = ns / period * period, into = ns - since;
      const long double slipped = into <= stick.ns ? 0 : static_cast<long double>(into - stick.ns) / slip.ns * period;
      const glm::dvec3 position = position_m(motion, RealTime{ns});
      for (int axis = 0; axis < 3; ++axis) {
        // Five roundings (velocity, fraction, sum, seconds, product), each by at most 2^-53 of a value below 4.
        const long double expected = static_cast<long double>(kVelocity[axis]) * ((since + slipped) / 1e9L);
        REQUIRE(std::abs(position[axis] - expected) <= 20 * 0x1p-53L);
      }
      // While it sticks, the hand stays where its period began, and that is on the mean line; both bit for bit.
      if (into <= stick.ns) REQUIRE(position == position_m(motion, RealTime{since}));
      REQUIRE(position_m(motion, RealTime{since}) == position_m(ConstantVelocity{kVelocity}, RealTime{since}));
    }
  }
}

TEST_CASE("a stick-slip motion never moves back, and is below its mean line by no more than v times the stick") {
  const StickSlip motion{{0.1, 0, 0}, Duration{90 * kMs + 1}, Duration{10 * kMs}};
  double before = 0;
  for (std::int64_t ns = 0; ns < kSecond; ns += 12'345) {
    const double x = x_m(motion, ns), behind = 0.1 * static_cast<double>(ns) / 1e9 - x;
    REQUIRE(x >= before);
    REQUIRE((behind >= -1e-17 && behind <= 0.1 * 0.090000001 + 1e-16));
    before = x;
  }
}

TEST_CASE("a stick-slip motion without a stick is constant velocity, bit for bit") {
  for (const std::int64_t slip : {std::int64_t{1}, std::int64_t{7}, 10 * kMs, kSecond + 1}) {
    for (std::int64_t k = 0; k < 2000; ++k) {
      const RealTime at{k * 7'654'321};
      const glm::dvec3 line = position_m(ConstantVelocity{kVelocity}, at);
      REQUIRE(position_m(StickSlip{kVelocity, Duration{0}, Duration{slip}}, at) == line);
    }
  }
}

TEST_CASE("at 0.1 m/s a stick-slip motion is on whole nanometres wherever its bracket is whole microseconds") {
  // It slips for a tenth of the time, so in a microsecond it moves by 10 times 100 nm.
  const StickSlip motion{{0.1, -0.1, 0}, Duration{90 * kMs}, Duration{10 * kMs}};
  for (std::int64_t us = 0; us < 20'000'000; us += 37) {
    const std::int64_t into = us % 100'000, run_us = us - into + std::max<std::int64_t>(0, into - 90'000) * 10;
    const glm::dvec3 position = position_m(motion, RealTime{us * 1000});
    REQUIRE(std::abs(position.x - static_cast<long double>(run_us * 100) / 1e9L) <= 7e-16L);  // as constant velocity
    const auto nm = static_cast<std::int32_t>(run_us * 100);
    REQUIRE(reference_device::to_nm(position) == std::array<std::int32_t, 3>{nm, -nm, 0});
  }
}

TEST_CASE("a recorded motion goes through its rows, straight between them, and holds its ends") {
  // The quarters of these whole numbers are exact, so the test may ask for equality.
  const RecordedMotion motion{
      {{RealTime{-8}, {1, 0, 0}}, {RealTime{0}, {9, -4, 0}}, {RealTime{4}, {1, -8, 2}}, {RealTime{5}, {0, 0, 0}}}};
  CHECK(position_m(motion, RealTime{INT64_MIN / 2}) == glm::dvec3(1, 0, 0));
  CHECK(position_m(motion, RealTime{INT64_MAX / 2}) == glm::dvec3(0, 0, 0));
  for (const auto& [at, position] : motion.rows) CHECK(position_m(motion, at) == position);
  for (std::int64_t ns = -8; ns <= 0; ++ns) CHECK(x_m(motion, ns) == 9.0 + static_cast<double>(ns));
  for (std::int64_t ns = 0; ns <= 4; ++ns) CHECK(x_m(motion, ns) == 9.0 - 2.0 * static_cast<double>(ns));
  const RecordedMotion one_row{{{RealTime{3}, {1, 2, 3}}}};
  for (const std::int64_t ns : {2, 3, 4}) CHECK(position_m(one_row, RealTime{ns}) == glm::dvec3(1, 2, 3));
}

TEST_CASE("before t = 0 every motion holds its position at 0") {
  const ConstantVelocity ramp{kVelocity, Duration{100 * kMs}, {0.1, 0.2, 0.3}};
  const std::array<Motion, 7> motions{Still{{1, 2, 3}},
                                      ramp,
                                      ConstantVelocity{kVelocity, Duration{0}, {1, 1, 1}},
                                      Sine{{1, 1, 1}, Rate{30, 1}},
                                      RampStop{ramp, RealTime{kSecond}},
                                      StickSlip{kVelocity, Duration{kMs}, Duration{kMs}},
                                      StickSlip{kVelocity, Duration{0}, Duration{1}}};
  for (const Motion& motion : motions) {
    for (std::int64_t ns = -1; ns > -kSecond * 1000; ns *= 7)
      CHECK(position_m(motion, RealTime{ns}) == position_m(motion, RealTime{0}));
  }
}

TEST_CASE("a minimum-jerk motion goes from rest to rest through its points by the closed form") {
  const MinimumJerk motion{{{{0.01, 0, -0.02}, Duration{400 * kMs}, Duration{100 * kMs}},
                            {{0.03, 0.01, 0}, Duration{kSecond}, Duration{0}},
                            {{0, 0, 0}, Duration{1}, Duration{0}}}};
  const auto part = [](long double u) { return u <= 0 ? 0 : u >= 1 ? 1 : u * u * u * (10 - 15 * u + 6 * u * u); };
  for (std::int64_t ns = -kMs; ns <= 1'500 * kMs; ns += 997'001) {
    const long double first = part(ns / 0.4e9L), second = part((ns - 500 * kMs) / 1e9L);
    const glm::dvec3 x = position_m(motion, RealTime{ns});
    // Room for a dozen roundings of values below 0.03.
    CHECK(std::abs(x.x - (0.01L * first + 0.02L * second)) < 1e-16);
    CHECK(std::abs(x.y - 0.01L * second) < 1e-16);
    CHECK(std::abs(x.z - (-0.02L * first + 0.02L * second)) < 1e-16);
  }
  CHECK(position_m(motion, RealTime{450 * kMs}) == glm::dvec3(0.01, 0, -0.02));  // at rest between two moves
  CHECK(position_m(motion, RealTime{1'500 * kMs}) == glm::dvec3(0.03, 0.01, 0));
  CHECK(position_m(motion, RealTime{1'500 * kMs + 1}) == glm::dvec3(0));
  CHECK(position_m(MinimumJerk{}, RealTime{kSecond}) == glm::dvec3(0));
}

TEST_CASE("a minimum-jerk move has its greatest speed, 15/8 of the mean, half-way, and no speed at its ends") {
  const MinimumJerk motion{{{{0.01, 0, 0}, Duration{400 * kMs}, Duration{0}}}};
  const auto speed = [&](std::int64_t ns) { return (x_m(motion, ns + 1000) - x_m(motion, ns - 1000)) / 2e-6; };
  double greatest = 0;
  for (std::int64_t ns = 0; ns <= 400 * kMs; ns += kMs) greatest = std::max(greatest, speed(ns));
  CHECK(greatest == Approx(1.875 * 0.01 / 0.4).epsilon(1e-9));
  CHECK(speed(200 * kMs) == Approx(greatest));
  CHECK(std::abs(speed(0)) < 1e-9);
  CHECK(std::abs(speed(400 * kMs)) < 1e-9);
}
