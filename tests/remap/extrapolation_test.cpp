#include "evenstep/remap/extrapolation.h"

#include "catch.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/sample_buffer.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr Rate kHandRate{1000, 1};

/// The reading at a time after the newest sample of `position`, which is sampled at 1 kHz. The ring holds all samples.
template <class Position>
double read(Extrapolation policy, std::int64_t newest, RealTime at, Position position) {
  SampleBuffer<double> buffer(static_cast<std::size_t>(newest) + 2, policy);
  for (std::int64_t k = 0; k <= newest; ++k)
    buffer.push(tick_time(kHandRate, k), position(seconds(tick_time(kHandRate, k))));
  return buffer.at(at).value;
}

/// The largest error when a 10 Hz sine of amplitude 1 is continued over this distance, of 1000 phases.
double sine_error(Extrapolation policy, Duration distance) {
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const auto sine = [&](double t_s) { return std::sin(2 * std::numbers::pi * (10 * t_s + i / 1000.0)); };
    const RealTime at = tick_time(kHandRate, 20) + distance;
    worst = std::max(worst, std::abs(read(policy, 20, at, sine) - sine(seconds(at))));
  }
  return worst;
}

}  // namespace

TEST_CASE("past the newest sample a line goes on as a line and is held from `furthest` on, every ns of small buffers") {
  for (std::int64_t spacing = 1; spacing <= 4; ++spacing) {
    for (std::int64_t window = 1; window <= 12; ++window) {
      for (std::int64_t furthest = 1; furthest <= 12; ++furthest) {
        SampleBuffer<double> samples(8, {{window}, {furthest}});
        ForceSchedule<double> forces(8, Emission::linear, {{window}, {furthest}});
        ForceSchedule<double> held(8, Emission::hold, {{window}, {furthest}});
        for (std::int64_t i = 0; i < 5; ++i) {
          samples.push(RealTime{100 + spacing * i}, 3.0 * static_cast<double>(spacing * i));
          forces.push(RealTime{100 + spacing * i}, 3.0 * static_cast<double>(spacing * i));
          held.push(RealTime{100 + spacing * i}, 3.0 * static_cast<double>(spacing * i));
        }
        const bool known = window <= 4 * spacing;
        for (std::int64_t beyond = 1; beyond <= 20; ++beyond) {
          const RealTime at{100 + 4 * spacing + beyond};
          const double goes_on = known ? static_cast<double>(std::min(beyond, furthest)) : 0;
          const double expected = 3 * (4 * static_cast<double>(spacing) + goes_on);
          REQUIRE(samples.at(at).value == Approx(expected).epsilon(1e-14));  // two roundings
          REQUIRE(samples.at(at).status == ReadStatus::underrun);
          REQUIRE(forces.at(at).value == Approx(expected).epsilon(1e-14));
          REQUIRE(forces.at(at).status == ReadStatus::underrun);
          REQUIRE(held.at(at).value == 12.0 * static_cast<double>(spacing));
          REQUIRE(held.at(at).status == ReadStatus::inside);
        }
      }
    }
  }
}

TEST_CASE("without window or distance, with one entry, or with the window out of the ring the newest value is held") {
  const Extrapolation nones[]{{}, {{}, {5}}, {{5}, {}}, {{-1}, {5}}, {{5}, {-1}}};
  for (const Extrapolation none : nones) {
    SampleBuffer<double> buffer(4, none);
    for (int i = 0; i < 6; ++i) buffer.push(RealTime{5 * i}, 0.1 * i * i);
    for (std::int64_t at = 26; at < 60; ++at) REQUIRE(buffer.at(RealTime{at}).value == 0.1 * 25);
  }
  SampleBuffer<double> one(4, {{1}, {100}});
  one.push(RealTime{10}, 7);
  CHECK(one.at(RealTime{20}).value == 7);
  SampleBuffer<double> full(2, {{20}, {100}});
  for (int i = 0; i < 3; ++i) full.push(RealTime{10 * i}, i);
  CHECK(full.at(RealTime{30}).value == 2);  // 0 has left a ring of 2: the value is held, not continued on another line
  SampleBuffer<double> fits(3, {{20}, {100}});
  for (int i = 0; i < 3; ++i) fits.push(RealTime{10 * i}, i);
  CHECK(fits.at(RealTime{30}).value == 3);
}

TEST_CASE("the line starts at the interpolated value one window back, and a constant stays its very bits") {
  SampleBuffer<double> buffer(8, {{15}, {100}});
  buffer.push(RealTime{0}, 5);
  buffer.push(RealTime{10}, 1);
  buffer.push(RealTime{20}, 4);  // at 5: 3; slope 1/15
  CHECK(buffer.at(RealTime{35}).value == 5);
  CHECK(buffer.at(RealTime{65}).value == 7);
  SampleBuffer<double> constant(8, {{15}, {100}});
  for (int i = 0; i < 5; ++i) constant.push(RealTime{10 * i}, 0.1);
  for (std::int64_t at = 41; at < 200; ++at) REQUIRE(constant.at(RealTime{at}).value == 0.1);
}

TEST_CASE("a read past the newest entry of a head does not see what came later") {
  SampleBuffer<double> buffer(8, {{10}, {100}});
  ForceSchedule<double> forces(8, Emission::linear, {{10}, {100}});
  for (int i = 0; i < 3; ++i) {
    buffer.push(RealTime{10 * i}, i);
    forces.push(RealTime{10 * i}, i);
  }
  for (int i = 3; i < 7; ++i) {
    buffer.push(RealTime{10 * i}, -50);
    forces.push(RealTime{10 * i}, -50);
    CHECK(buffer.at(RealTime{25}, 3).value == 2.5);
    CHECK(forces.at(RealTime{25}, 3).value == 2.5);
  }
}

TEST_CASE("forces repaired to 1 ns apart do not throw the line, it bends by their difference only") {
  ForceSchedule<double> forces(8, Emission::linear, kContinueLine);
  forces.push(RealTime{0}, 1.0);
  forces.push(RealTime{2'000'000}, 1.2);
  forces.push(RealTime{4'000'000}, 1.4);
  forces.push(RealTime{4'000'001}, 1.5);  // slope through the last two: 1e8 N/s
  const double slope_N_per_ms = (1.5 - 1.0) / 4;
  CHECK(forces.at(RealTime{5'000'001}).value == Approx(1.5 + slope_N_per_ms).epsilon(1e-6));
  CHECK(forces.at(RealTime{14'000'001}).value == Approx(1.5 + 10 * slope_N_per_ms).epsilon(1e-6));
  CHECK(forces.at(RealTime{99'000'001}).value == forces.at(RealTime{14'000'001}).value);
}

TEST_CASE("`extrapolate` errs by at most 28 % of a 10 Hz sine after 10 ms, and no more after that than holding does") {
  // With w = 62.8/s, w^2 b (b + window) / 2 bounds the error of the line, and w b that of holding near the steepest place.
  for (std::int64_t ms = 1; ms <= 10; ++ms) {
    const double b_s = static_cast<double>(ms) * 1e-3, w = 20 * std::numbers::pi;
    const double error = sine_error(kContinueLine, {ms * 1'000'000});
    REQUIRE(error <= w * w * b_s * (b_s + 4e-3) / 2);
    REQUIRE(error >= 0.9 * w * w * b_s * (b_s + 4e-3) / 2 * (1 - w * w * b_s * b_s / 6));  // and it is not far below
    REQUIRE(error < 0.6 * sine_error(kHoldNewest, {ms * 1'000'000}));
  }
  CHECK(sine_error(kContinueLine, {10'000'000}) <= 0.28);
  // The line is held from 10 ms on. Half a period later it is off by as much as holding from 0 on; without that limit it is
  // off by more.
  CHECK(sine_error(kContinueLine, {50'000'000}) <= 1.1 * sine_error(kHoldNewest, {50'000'000}));
  CHECK(sine_error({{4'000'000}, {INT64_MAX}}, {50'000'000}) > 1.5 * sine_error(kHoldNewest, {50'000'000}));
}

TEST_CASE("`predict` is exact on constant velocity at any distance, and wrong by v b after a dead stop") {
  constexpr double v = 0.1;
  for (std::int64_t ms = 1; ms <= 500; ++ms) {
    const RealTime at = tick_time(kHandRate, 50 + ms);
    // The distance is up to 60 windows, so the rounding of a value counts up to 60 times.
    REQUIRE(read(kPredictHand, 50, at, [](double t_s) { return v * t_s; }) == Approx(v * seconds(at)).epsilon(1e-12));
  }
  const auto stopping = [](double t_s) { return v * std::min(t_s, 0.05); };
  CHECK(read(kPredictHand, 50, tick_time(kHandRate, 60), stopping) == Approx(0.005 + 0.001).epsilon(1e-9));
  CHECK(read(kHoldNewest, 50, tick_time(kHandRate, 60), stopping) == v * 0.05);
}

TEST_CASE("policies work on arrays, componentwise") {
  using Vector = std::array<double, 3>;
  SampleBuffer<Vector> buffer(4, {{10}, {20}});
  buffer.push(RealTime{0}, {0, 1, 2});
  buffer.push(RealTime{10}, {1, 1, 0});
  CHECK(buffer.at(RealTime{20}).value == Vector{2, 1, -2});
  CHECK(buffer.at(RealTime{90}).value == Vector{3, 1, -4});
}
