
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "units.h"
#include "vectors.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

HandSpec mass_only(double mass_kg) {
  HandSpec spec;
  spec.mass_kg = mass_kg;
  spec.damping_N_s_per_m = 0;
  return spec;
}

/// A hand that is released at 10 mm on a spring, with a damping ratio below 1.
HandSpec oscillator(double omega_per_s, double damping_ratio) {
  HandSpec spec = mass_only(0.2);
  spec.stiffness_N_per_m = 0.2 * omega_per_s * omega_per_s;
  spec.damping_N_s_per_m = 2 * damping_ratio * 0.2 * omega_per_s;
  spec.offset_m = {0.01, 0, 0};
  return spec;
}

double exact_m(double omega, double ratio, double t) {
  const double damped = omega * std::sqrt(1 - ratio * ratio);
  return 0.01 * std::exp(-ratio * omega * t) * (std::cos(damped * t) + ratio * omega / damped * std::sin(damped * t));
}

double worst_error_m(double omega, double ratio, Duration grid, double seconds_long) {
  Hand hand(oscillator(omega, ratio), {}, grid);
  double worst = 0;
  for (std::int64_t ns = 0; ns <= static_cast<std::int64_t>(seconds_long * 1e9); ns += kMs)
    worst = std::max(worst, std::abs(hand.position_m(RealTime{ns}).x - exact_m(omega, ratio, ns / 1e9)));
  return worst;
}

}  // namespace

TEST_CASE("a free mass flies its parabola exactly, however the force changes within a grid step") {
  for (const double mass : {0.01, 0.2, 3.0}) {
    HandSpec spec = mass_only(mass);
    spec.velocity_m_per_s = {0.1, -0.2, 0};
    Hand hand(spec, {});
    // The position at the end of each piece, from the closed form of that piece, in long double.
    long double x = 0, v = 0.1L;
    std::int64_t at = 0;
    double force = 0;
    const std::array<std::int64_t, 6> lengths{kMs, 999'999, 1, 25'001, 12'345'678, 24'999};
    for (int round = 0; round < 200; ++round) {
      for (const std::int64_t length : lengths) {
        force = 0.01 * mass * ((round * 7 + static_cast<int>(length % 11)) % 13 - 6);
        hand.feel(RealTime{at}, {force, 0, 0});
        const long double dt = length / 1e9L;
        x += v * dt + force / mass * dt * dt / 2;
        v += force / mass * dt;
        at += length;
        // Each step rounds by about 1e-16 m, and a round has some 600 steps.
        REQUIRE(std::abs(hand.position_m(RealTime{at}).x - x) < 1e-12);
      }
    }
  }
}

TEST_CASE(
    "an oscillator stays within its phase error of the exact solution, and the error falls with the square of the grid") {
  for (const double omega : {5.0, 40.0, 400.0, 2000.0}) {
    for (const double ratio : {0.0, 0.02, 0.3}) {
      CAPTURE(omega, ratio);
      const double h = 25e-6, long_s = 0.5;
      const double error = worst_error_m(omega, ratio, kHandStep, long_s);
      // The frequency is off by (w h)^2 / 24, and the damping by as much. So the phase is off by that times w t, where t
      // goes to the end without damping and to the decay time 1 / (ratio w) with it. The amplitude is 10 mm.
      const double t = ratio > 0 ? std::min(long_s, 1 / (ratio * omega)) : long_s;
      CHECK(error <= 0.01 * (omega * h) * (omega * h) / 24 * (omega * t + 3) * 1.2 + 1e-12);
      const double coarse = worst_error_m(omega, ratio, kHandStep * 2, long_s);
      if (error > 1e-10 && coarse < 1e-4) CHECK(coarse / error == Approx(4).epsilon(0.05));
    }
  }
}

TEST_CASE("without damping an oscillator keeps its swing for a million steps") {
  Hand hand(oscillator(100, 0), {});
  double late = 0;
  for (std::int64_t ns = 25 * kSecond; ns < 25 * kSecond + 200 * kMs; ns += 100 * kUs)
    late = std::max(late, std::abs(hand.position_m(RealTime{ns}).x));
  // Verlet swings on an ellipse that differs by (w h)^2 / 8. Samples every 0.1 ms miss the peak by (w 0.05 ms)^2 / 2.
  CHECK(late == Approx(0.01).epsilon(2e-5));
}

TEST_CASE("an arm's damper and spring follow the path, so a hand without friction of its own stays on a straight one") {
  HandSpec spec = mass_only(0.2);
  spec.arm = {0.554, 6.45, 135};
  spec.velocity_m_per_s = {0.1, 0, 0};
  const ProgrammedMotion path{ConstantVelocity{{0.1, 0, 0}, Duration{0}}, RealTime{0}};
  Hand hand(spec, path);
  for (std::int64_t ns = 0; ns <= 3 * kSecond; ns += 777'777)
    CHECK(std::abs(hand.position_m(RealTime{ns}).x - 0.1 * (ns / 1e9)) < 1e-12);

  // With friction of its own the hand stays behind by b v / k: there the spring makes up for the friction.
  spec.damping_N_s_per_m = 1;
  Hand dragged(spec, path);
  CHECK(dragged.position_m(RealTime{10 * kSecond}).x == Approx(1.0 - 1 * 0.1 / 135).epsilon(1e-6));
}

TEST_CASE("a push moves the rest position by push over stiffness, on each axis") {
  HandSpec spec = oscillator(30, 0.7);
  spec.push_N = {1, -2, 0.5};
  Hand hand(spec, {});
  const glm::dvec3 rest_m = spec.push_N / spec.stiffness_N_per_m, x = hand.position_m(RealTime{5 * kSecond});
  for (int axis = 0; axis < 3; ++axis) CHECK(x[axis] == Approx(rest_m[axis]).epsilon(1e-9));
}

TEST_CASE("asking for positions in between changes none of those that follow") {
  HandSpec spec = oscillator(50, 0.05);
  spec.arm = {0.5, 3, 100};
  const ProgrammedMotion path{Sine{{0.02, 0.01, 0}, Rate{3, 1}}, RealTime{10 * kMs}};
  Hand seldom(spec, path), often(spec, path);
  for (std::int64_t k = 1; k <= 300; ++k) {
    for (std::int64_t ns = (k - 1) * kMs; ns < k * kMs; ns += 3'333) often.position_m(RealTime{ns});
    REQUIRE(same_bits(seldom.position_m(RealTime{k * kMs}), often.position_m(RealTime{k * kMs})));
    const glm::dvec3 force(std::fmod(k * 0.37, 1.0), -0.1, 0);
    seldom.feel(RealTime{k * kMs + 12'345}, force);
    often.feel(RealTime{k * kMs + 12'345}, force);
  }
}

TEST_CASE("a hand rests where it starts before t = 0 and leaves its reach with a time and a distance") {
  HandSpec spec = mass_only(0.2);
  spec.offset_m = {0.25, 0, 0};
  spec.push_N = {-10, 0, 0};
  Hand hand(spec, {Still{{0.5, 0, 0}}, RealTime{0}});
  CHECK(hand.position_m(RealTime{-5}).x == 0.75);
  CHECK(hand.position_m(RealTime{0}).x == 0.75);
  // The end at -2 m is 2.75 m away, which takes sqrt(2 * 2.75 m * 0.2 kg / 10 N) = 0.3317 s.
  const double out_s = std::sqrt(2 * 2.75 * 0.2 / 10);
  CHECK_NOTHROW(hand.position_m(RealTime{static_cast<std::int64_t>((out_s - 1e-4) * 1e9)}));
  try {
    hand.position_m(RealTime{kSecond});
    FAIL("it should be gone");
  } catch (const HandDiverged& diverged) {
    CHECK(seconds(diverged.at) == Approx(out_s).margin(26e-6));
    CHECK_THAT(diverged.what(), Catch::Contains("2 m") && Catch::Contains("0.3316"));
  }

  HandSpec broken = mass_only(0.2);
  broken.push_N = {NAN, 0, 0};
  Hand nowhere(broken, {});
  CHECK_THROWS_AS(nowhere.position_m(RealTime{kMs}), HandDiverged);
}

// The hand in its device.

namespace {

struct HandBench {
  HandBench(HandSpec spec, SimulatedDeviceOptions options)
      : transport(clock, Hand(std::move(spec), {}), std::move(options)) {}
  glm::dvec3 read_at(std::int64_t ns) {
    clock.wait_until(RealTime{ns});
    return driver.read(clock.now()).position_m;
  }
  VirtualClock clock;
  SimulatedTransport transport;
  ReferenceDriver driver{transport};
};

}  // namespace

TEST_CASE("a force is felt from its delay on, and a report is the hand's place to half a nanometre") {
  for (const std::int64_t delay_ns : {std::int64_t{0}, std::int64_t{1}, kMs, 2 * kMs, 1'234'567 * std::int64_t{1}}) {
    SimulatedDeviceOptions options;
    options.force_delay = Duration{delay_ns};
    HandBench bench(mass_only(0.2), options);
    CHECK(bench.read_at(0).x == 0);
    bench.driver.write({0.5, 0, 0});
    for (std::int64_t k = 1; k <= 50; ++k) {
      const double t = std::max<std::int64_t>(0, k * kMs - delay_ns) / 1e9;
      CHECK(std::abs(bench.read_at(k * kMs).x - 0.5 / 0.2 * t * t / 2) <= 0.501e-9);
    }
  }
}

TEST_CASE("the last force counts: one that is withdrawn before its delay has passed is felt only in between") {
  SimulatedDeviceOptions options;
  options.force_delay = Duration{3 * kMs};
  HandBench bench(mass_only(0.2), options);
  for (std::int64_t k = 0; k < 10; ++k) {
    bench.read_at(k * kMs);
    bench.driver.write({k == 2 ? 1.0 : 0.0, 0, 0});  // felt from 5 ms to 6 ms
  }
  const double v = 1 / 0.2 * 1e-3;
  CHECK(std::abs(bench.read_at(20 * kMs).x - (v * 0.5e-3 + v * 14e-3)) <= 0.501e-9);
}

TEST_CASE("after a stall both queues hold what a reader without one saw, and the hand has moved on") {
  for (const QueuePolicy policy : {QueuePolicy::hidraw, QueuePolicy::libusb}) {
    SimulatedDeviceOptions options;
    options.queue = policy;
    HandBench stalled(oscillator(60, 0.01), options), fluent(oscillator(60, 0.01), options);
    std::vector<glm::dvec3> seen;
    for (std::int64_t k = 0; k <= 400; ++k) seen.push_back(fluent.read_at(k * kMs));
    stalled.read_at(10 * kMs);
    stalled.clock.wait_until(RealTime{300 * kMs});
    std::array<std::byte, 64> buffer;
    int reports = 0;
    for (;; ++reports) {
      const HidRead got = stalled.transport.read(buffer);
      if (got.status != HidRead::Status::report) break;
      const auto report = reference_device::decode_input(std::span(buffer).first(got.size));
      REQUIRE(report->position_nm == reference_device::to_nm(seen[report->sequence - 1]));
    }
    CHECK(reports == (policy == QueuePolicy::hidraw ? 63 : 32));
    CHECK(same_bits(stalled.read_at(301 * kMs), seen[301]));
  }
}

TEST_CASE("a device that is gone feels nothing more, and a diverged hand is named by its device") {
  SimulatedDeviceOptions options;
  options.unplug_at_tick = 5;
  HandBench bench(mass_only(0.2), options);
  bench.read_at(4 * kMs);
  CHECK_THROWS_AS(bench.read_at(5 * kMs), DeviceError);
  CHECK_THROWS_AS(bench.driver.write({1, 0, 0}), DeviceError);

  options.unplug_at_tick = -1;
  options.name = "left";
  HandBench pushed(mass_only(0.2), options);
  pushed.read_at(0);
  pushed.driver.write({100, 0, 0});
  CHECK_THROWS_WITH(pushed.read_at(kSecond), Catch::StartsWith("left: the hand is more than 2 m away at 0.0894"));
}
