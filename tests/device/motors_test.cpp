// What the motors of simulated devices did, compared with what must follow from what was written to them and when.
#include <cmath>

#include "catch.h"
#include "evdev/evdev_bench.h"
#include "evenstep/device/evdev/simulated_evdev.h"
#include "evenstep/device/hid/reference_driver.h"
#include "evenstep/device/hid/simulated_transport.h"
#include "evenstep/device/inverse3/inverse3_driver.h"
#include "evenstep/device/inverse3/simulated_inverse3.h"
#include "pid/pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;
using Kind = ReportFault::Kind;

namespace {

struct MotorsBench {
  explicit MotorsBench(SimulatedDeviceOptions options, Motion motion = Still{})
      : device(clock, ProgrammedMotion{std::move(motion), RealTime{}}, std::move(options)) {}
  DeviceSample tick(std::int64_t k, const glm::dvec3& force_N) {
    clock.wait_until(RealTime{k * kMs});
    const DeviceSample sample = driver.read(clock.now());
    driver.write(force_N);
    return sample;
  }
  VirtualClock clock;
  SimulatedTransport device;
  ReferenceDriver driver{device};
};

/// 10 N at the largest magnitude of 32767, and a gain of 1, so that all of it may be used.
PidOptions full_gain() {
  PidOptions options = pid_options();
  options.gain = 1;
  return options;
}

}  // namespace

TEST_CASE("the motors of a reference device render what it took and as long as nothing else comes") {
  // The output of some of the 40 ticks is lost. The force before them goes on for one tick more with each loss.
  for (std::int64_t lost = 0; lost < 20; ++lost) {
    MotorsBench bench({.faults = {{Kind::write_lost, 10, lost}}});
    for (int k = 0; k < 40; ++k) bench.tick(k, {0.003 * k, -0.004 * k, 0});
    const MotorState motors = bench.device.motors();
    CHECK(motors.force_N == glm::dvec3(0.117, -0.156, 0));
    CHECK(motors.largest_N == Approx(0.195).epsilon(1e-12));  // 5 uN times 39 thousand
    CHECK(motors.unrenewed.ns == (lost + 1) * kMs);
    CHECK(motors.effects_ended == 0);
    bench.clock.wait_until(RealTime{100 * kMs});
    CHECK(bench.device.motors().unrenewed.ns == 61 * kMs);  // since the last output, at 39 ms
    bench.driver.stop();
    CHECK(bench.device.motors().force_N == glm::dvec3(0));
    bench.clock.wait_until(RealTime{1000 * kMs});
    CHECK(bench.device.motors().unrenewed.ns == 61 * kMs);  // no force, nothing to renew
  }
}

TEST_CASE("a device that is gone renders nothing and keeps what it did") {
  MotorsBench bench({.unplug_at_tick = 20});
  for (std::int64_t k = 0; k < 20; ++k) bench.tick(k, {0, 2, 0});
  bench.clock.wait_until(RealTime{20 * kMs});
  CHECK(bench.device.motors().force_N == glm::dvec3(0));
  CHECK(bench.device.motors().largest_N == 2);

  SimulatedPidOptions options = pid_device(PidFlavour::mask);
  options.reports.unplug_at_tick = 20;
  PidBench pid(options, full_gain());
  pid.driver->start();
  for (std::int64_t k = 0; k < 20; ++k) pid.tick_at(k * kMs, {0, 2, 0});
  CHECK(pid.device.motors().effects_playing == 2);
  pid.clock.wait_until(RealTime{20 * kMs});
  const MotorState gone = pid.device.motors();
  CHECK(is_still(gone));
  CHECK(gone.largest_N == Approx(2).margin(10.0 / 32767));
}

TEST_CASE("the motors of a PID device are on while its driver runs and off and empty after its stop") {
  for (const PidFlavour flavour : kFlavours) {
    PidBench bench(pid_device(flavour), full_gain());
    CHECK_FALSE(bench.device.motors().actuators_enabled);
    bench.driver->start();
    bench.tick_at(kMs, {3, -4, 0});
    const MotorState driven = bench.device.motors();
    CHECK((driven.actuators_enabled && driven.effects_playing == 2 && driven.effects_allocated == 2));
    // The direction of the coarser flavour turns 0.62 % of the 3 N to Y.
    CHECK(driven.largest_N == Approx(5).margin(0.02));
    bench.driver->stop();
    const MotorState left = bench.device.motors();
    CHECK(is_still(left));
    CHECK(left.effects_ended == 0);  // the effects were stopped, they did not end by themselves
  }
}

TEST_CASE("effects that nobody refreshes end once each at their duration and the force with them") {
  for (const PidFlavour flavour : kFlavours) {
    for (std::int64_t duration_ms = 10; duration_ms <= 500; duration_ms += 49) {
      PidOptions options = full_gain();
      options.effect_duration = Duration{duration_ms * kMs};
      PidBench bench(pid_device(flavour), options);
      bench.driver->start();
      bench.tick_at(kMs, {3, 0, 0});  // force and Start
      bench.clock.wait_until(RealTime{(duration_ms + 1) * kMs - 1});
      CHECK(bench.device.motors().force_N.x > 2.9);
      CHECK(bench.device.motors().effects_ended == 0);
      bench.clock.wait_until(RealTime{10'000 * kMs});
      const MotorState ended = bench.device.motors();
      CHECK(ended.force_N == glm::dvec3(0));
      CHECK(ended.effects_ended == 2);
      CHECK(ended.unrenewed.ns == duration_ms * kMs);
    }
  }
}

TEST_CASE("a switch ends a force and a force that comes back is counted from then on") {
  SimulatedPidOptions options = pid_device(PidFlavour::mask);
  options.events = {{PidDeviceEvent::Kind::safety_switch, RealTime{100 * kMs}, false},
                    {PidDeviceEvent::Kind::safety_switch, RealTime{300 * kMs}, true}};
  PidOptions driver = full_gain();
  driver.effect_duration = Duration{10'000 * kMs};
  PidBench bench(options, driver);
  bench.driver->start();
  bench.tick_at(kMs, {3, 0, 0});
  bench.clock.wait_until(RealTime{300 * kMs});
  CHECK(bench.device.motors().unrenewed.ns == 99 * kMs);
  bench.clock.wait_until(RealTime{450 * kMs});
  CHECK(bench.device.motors().unrenewed.ns == 150 * kMs);
}

TEST_CASE("a spring that a PID device renders by itself shows in its motors with a hand and without") {
  // 25 N/m; at most 50 N/m are possible, which is 10 N over 0.2 m. The device moves at 0.1 m/s.
  SimulatedPidOptions options = pid_device(PidFlavour::mask);
  PidOptions driver = full_gain();
  driver.springs = true;
  driver.reversed_spring[0] = false;
  PidBench bench(options, driver, ConstantVelocity{{0.1, 0, 0}, Duration{0}});
  bench.driver->start();
  bench.tick_at(0, {0, 0, 0});
  DeviceSpring spring;
  spring.below_N_per_m = spring.above_N_per_m = {25, 25, 0};
  spring.limit_N = {10, 10, 0};
  bench.driver->write_spring(spring);
  bench.clock.wait_until(RealTime{400 * kMs});
  // After 0.4 s the device is at 40 mm, which makes 1 N up to a count of the coefficient.
  CHECK(bench.device.motors().force_N.x == Approx(-1).epsilon(1e-3));
  CHECK(bench.device.motors().largest_N == Approx(1).epsilon(1e-3));
  CHECK(bench.device.motors().unrenewed.ns >= 399 * kMs);
}

TEST_CASE("while nobody reads the queue fills as its policy says and the first read afterwards shows it") {
  const ConstantVelocity hand{{0.1, 0, 0}, Duration{0}};  // 0.1 mm a tick
  for (const QueuePolicy policy : {QueuePolicy::hidraw, QueuePolicy::libusb}) {
    for (std::int64_t ticks = 1; ticks <= 100; ++ticks) {
      std::vector<ReportFault> faults;
      for (std::int64_t i = 0; i < ticks; ++i) faults.push_back({Kind::unread, 50 + i, 1});
      MotorsBench bench({.queue = policy, .faults = faults}, hand);
      DeviceSample sample;
      for (std::int64_t k = 0; k <= 50 + ticks; ++k) {
        sample = bench.tick(k, {1, 0, 0});
        REQUIRE(sample.fresh == (k < 50 || k == 50 + ticks));
        if (k >= 50 && k < 50 + ticks) REQUIRE(sample.position_m.x == Approx(4.9e-3).margin(1e-9));
      }
      // ticks + 1 reports needed a place in the queue.
      const bool hidraw = policy == QueuePolicy::hidraw;
      const std::int64_t dropped = std::max<std::int64_t>(0, ticks + 1 - (hidraw ? 63 : 32));
      CHECK(bench.device.dropped() == dropped);
      CHECK(sample.position_m.x == Approx(1e-4 * static_cast<double>(50 + ticks - (hidraw ? dropped : 0))).margin(1e-9));
      bench.tick(51 + ticks, {1, 0, 0});
      CHECK(bench.driver.counters().lost == dropped);
      CHECK(bench.driver.counters().stale == ticks);
    }
  }
}

TEST_CASE("a hand that leaves its reach is said once and its device can be stopped all the same") {
  HandSpec thrown;
  thrown.push_N = {100, 0, 0};  // 2 m away after 90 ms
  for (const std::int64_t at_ms : {100, 200, 5000}) {
    VirtualClock clock;
    SimulatedTransport device(clock, Hand(thrown, {}), {});
    ReferenceDriver driver(device);
    driver.write({1, 0, 0});
    clock.wait_until(RealTime{at_ms * kMs});
    CHECK_THROWS_AS(driver.read(clock.now()), HandDiverged);
    CHECK(device.motors().force_N.x == 1);
    driver.stop();
    CHECK(device.motors().force_N == glm::dvec3(0));

    PidBench bench(pid_device(PidFlavour::mask), full_gain(), Hand(thrown, {}));
    bench.driver->start();
    bench.tick_at(0, {1, 0, 0});
    bench.clock.wait_until(RealTime{at_ms * kMs});
    CHECK_THROWS_AS(bench.driver->read(bench.clock.now()), HandDiverged);
    bench.driver->stop();
    CHECK(is_still(bench.device.motors()));
  }
}

TEST_CASE("a hand that leaves its reach while its device is stopped does not keep the device from being stopped") {
  HandSpec thrown;
  thrown.push_N = {100, 0, 0};  // 2 m away after 90 ms
  const RealTime later{200 * kMs};
  {
    VirtualClock clock;
    SimulatedTransport device(clock, Hand(thrown, {}), {});
    ReferenceDriver driver(device);
    driver.write({1, 0, 0});
    clock.wait_until(later);
    driver.stop();
    CHECK(device.motors().force_N == glm::dvec3(0));
  }
  {
    PidBench bench(pid_device(PidFlavour::mask), full_gain(), Hand(thrown, {}));
    bench.driver->start();
    bench.tick_at(0, {1, 0, 0});
    bench.clock.wait_until(later);
    bench.driver->stop();
    CHECK(is_still(bench.device.motors()));
  }
  {
    VirtualClock clock;
    SimulatedEvdev device(clock, Hand(thrown, {}), {});
    EvdevDriver driver(device, evdev_options());
    driver.start();
    driver.read(clock.now());
    driver.write({1, 0, 0});
    clock.wait_until(later);
    driver.stop();
    CHECK(is_still(device.motors()));
  }
  {
    VirtualClock clock;
    SimulatedInverse3 service(clock, Hand(thrown, {}), {});
    Inverse3Driver driver(service, {});
    driver.start();
    driver.read(clock.now());
    driver.write({1, 0, 0});
    clock.wait_until(later);
    driver.stop();
    CHECK(service.motors().force_N == glm::dvec3(0));
  }
}
