// A simulated device that is unplugged and plugged in again, under its real driver and the force guard, on the virtual
// clock.

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <random>

#include "catch.h"
#include "evdev/evdev_bench.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/evdev/simulated_evdev.h"
#include "evenstep/device/force_guard.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "evenstep/device/inverse3/inverse3_driver.h"
#include "evenstep/device/inverse3/simulated_inverse3.h"
#include "evenstep/device/looked_for.h"
#include "units.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr double kWanted_N = 2, kVelocity_m_per_s = 0.02;

enum class DeviceKind { reference, evdev, inverse3 };

/// A device that goes and comes back, its driver, and a guard over it. A force of 2 N is wanted all the time.
struct ReturnBench {
  ReturnBench(DeviceKind kind, std::int64_t unplug_tick, std::int64_t return_tick, const CutLimits& cut)
      : guard(limits(cut)) {
    SimulatedDeviceOptions options;
    options.unplug_at_tick = unplug_tick;
    options.return_at_tick = return_tick;
    const ProgrammedMotion motion{ConstantVelocity{{kVelocity_m_per_s, 0, 0}}, RealTime{}};
    if (kind == DeviceKind::reference) {
      hid = std::make_unique<SimulatedTransport>(clock, motion, options);
      driver = std::make_unique<ReferenceDriver>(*hid);
      motors = hid.get();
    } else if (kind == DeviceKind::evdev) {
      SimulatedEvdevOptions with;
      with.reports = options;
      node = std::make_unique<SimulatedEvdev>(clock, motion, with);
      driver = std::make_unique<EvdevDriver>(*node, evdev_options());
      motors = node.get();
    } else {
      SimulatedInverse3Options with;
      with.reports = options;
      service = std::make_unique<SimulatedInverse3>(clock, motion, with);
      driver = std::make_unique<Inverse3Driver>(*service, Inverse3Options{});
      motors = service.get();
    }
    driver->start();
  }
  static ForceLimits limits(const CutLimits& cut) {
    ForceLimits limits;
    limits.cut = cut;
    return limits;
  }
  DeviceSample tick() {
    clock.wait_until(clock.now() + Duration{kMs});
    const DeviceSample sample = driver->read(clock.now());
    sent_N = guard.pass(clock.now(), {kWanted_N, 0, 0}, {sample, clock.now()}).x;
    driver->write({sent_N, 0, 0});
    return sample;
  }

  VirtualClock clock;
  ForceGuard guard;
  std::unique_ptr<SimulatedTransport> hid;
  std::unique_ptr<SimulatedEvdev> node;
  std::unique_ptr<SimulatedInverse3> service;
  std::unique_ptr<HapticDevice> driver;
  SimulatedMotors* motors = nullptr;
  double sent_N = 0;
};

std::int64_t between(std::mt19937_64& random, std::int64_t least, std::int64_t most) {
  return least + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most - least + 1));
}

}  // namespace

TEST_CASE("a device is found at the first look that is not before its return, and not after ten seconds") {
  const RealTime lost{7 * kMs};
  const auto found_after = [&](std::int64_t away_ns) { return found_again(lost, lost + Duration{away_ns}); };
  CHECK(found_after(1) == lost + Duration{250 * kMs});
  CHECK(found_after(250 * kMs) == lost + Duration{250 * kMs});
  CHECK(found_after(250 * kMs + 1) == lost + Duration{500 * kMs});
  CHECK(found_after(10'000 * kMs) == lost + Duration{10'000 * kMs});
  CHECK_FALSE(found_after(10'000 * kMs + 1));
}

TEST_CASE("a returning device is not pushed while it is away and then by a force that rises from zero, at random times") {
  std::mt19937_64 random(20261123);
  for (int round = 0; round < 60; ++round) {
    const DeviceKind kind{round % 3};
    const std::int64_t unplug = between(random, 400, 700), returns = unplug + between(random, 1, 900);
    CutLimits cut;
    cut.ramp_up = Duration{between(random, 20, 300) * kMs};
    cut.ramp_down = Duration{between(random, 0, 3) * between(random, 0, 1000) * kMs};  // may exceed the absence
    if (random() % 2) cut.stale_hand = Duration{between(random, 5, 400) * kMs};
    INFO("round " << round << ", unplugged at " << unplug << " ms, returns at " << returns << " ms, ramp_up "
                  << cut.ramp_up.ns / kMs << " ms, ramp_down " << cut.ramp_down.ns / kMs << " ms");
    ReturnBench bench(kind, unplug, returns, cut);
    const std::int64_t found = found_again(RealTime{unplug * kMs}, RealTime{returns * kMs})->ns / kMs;
    const double steepest_N = kWanted_N * kMs / static_cast<double>(cut.ramp_up.ns) * (1 + 1e-9);
    double before_N = 0;
    for (std::int64_t ms = 1; ms < found + cut.ramp_up.ns / kMs + 100; ++ms) {
      const DeviceSample sample = bench.tick();
      INFO(ms << " ms");
      REQUIRE(sample.away == (ms >= unplug && ms <= found));
      REQUIRE(bench.sent_N - before_N <= steepest_N);
      if (sample.away) {
        REQUIRE_FALSE(sample.drivable);
        REQUIRE(bench.sent_N == 0);
        REQUIRE((ms == found || !sample.fresh));
        REQUIRE(bench.motors->motors().force_N == glm::dvec3(0));
      } else if (ms > found + 1) {
        REQUIRE(sample.fresh);
        REQUIRE(sample.position_m.x == Approx(kVelocity_m_per_s * static_cast<double>(ms) * 1e-3).margin(1e-5));
      }
      if (ms == unplug - 1) REQUIRE(bench.motors->motors().force_N.x == Approx(kWanted_N).margin(1e-3));
      before_N = bench.sent_N;
    }
    CHECK(bench.sent_N == kWanted_N);
    const MotorState end = bench.motors->motors();
    CHECK(end.force_N.x == Approx(kWanted_N).margin(1e-3));
    REQUIRE(end.asked_away_N);
    CHECK(*end.asked_away_N == 0);
    bench.driver->stop();
    CHECK(bench.motors->motors().force_N == glm::dvec3(0));
  }
}

TEST_CASE("a device that is away for more than ten seconds, or does not return, ends the run") {
  for (const DeviceKind kind : {DeviceKind::reference, DeviceKind::evdev, DeviceKind::inverse3}) {
    ReturnBench never(kind, 100, -1, {}), late(kind, 100, 10'101, {});
    for (int ms = 1; ms < 100; ++ms) never.tick();
    CHECK_THROWS_AS(never.tick(), DeviceError);
    for (int ms = 1; ms <= 10'100; ++ms) late.tick();
    CHECK_THROWS_AS(late.tick(), DeviceError);
    late.driver->stop();
  }
}

TEST_CASE("simulated evdev: a device that was plugged in centers by itself until it is found and told not to") {
  VirtualClock clock;
  SimulatedEvdevOptions options;
  options.reports.unplug_at_tick = 1000;
  options.reports.return_at_tick = 1100;
  SimulatedEvdev device(clock, ProgrammedMotion{ConstantVelocity{{kVelocity_m_per_s, 0, 0}}, RealTime{}}, options);
  EvdevDriver driver(device, evdev_options());
  driver.start();
  const auto tick_until = [&](std::int64_t ms) {
    while (clock.now() < RealTime{ms * kMs}) {
      clock.wait_until(clock.now() + Duration{kMs});
      driver.read(clock.now());
      driver.write(glm::dvec3(0));
    }
    return device.motors();
  };
  CHECK(tick_until(1249).largest_N < 1e-3);  // a count of the level, at every second refresh
  CHECK(tick_until(1250).largest_N == Approx(10 * 25.0 / 200).margin(1e-6));
  CHECK(device.motors().force_N == glm::dvec3(0));
}

TEST_CASE("a hand feels nothing from the device that it holds from the moment that it is unplugged") {
  HandSpec spec;
  spec.mass_kg = 0.1;
  spec.damping_N_s_per_m = 0;
  VirtualClock clock;
  SimulatedDeviceOptions options;
  options.unplug_at_tick = 100;
  options.return_at_tick = 590;
  SimulatedTransport device(clock, Hand(spec, ProgrammedMotion{}), options);
  ReferenceDriver driver(device);
  DeviceSample sample;
  for (std::int64_t ms = 1; ms <= 600; ++ms) {
    clock.wait_until(RealTime{ms * kMs});
    sample = driver.read(clock.now());
    driver.write({1, 0, 0});
  }
  REQUIRE(sample.fresh);
  // The hand is pushed from 1 ms to 100 ms. Then it goes on at the speed that it has reached.
  const double pushed_s = 0.099, speed_m_per_s = 1 / spec.mass_kg * pushed_s;
  CHECK(sample.position_m.x == Approx(speed_m_per_s * (pushed_s / 2 + 0.5)).margin(1e-4));
}
