#include "evenstep/device/device_spring.h"

#include <cmath>
#include <random>

#include "catch.h"
#include "pid/pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

AffineContact wall(double stiffness_N_per_m, double surface_m, double outward) {
  AffineContact contact;
  contact.tool_m = {surface_m - outward * 0.01, 0, 0};
  contact.force_N = {outward * 0.01 * stiffness_N_per_m, 0, 0};
  contact.stiffness_N_per_m.xx = stiffness_N_per_m;
  contact.outward = {outward, 0, 0};
  return contact;
}

PidOptions with_springs() {
  PidOptions options = pid_options();
  options.springs = true;
  options.reversed_spring[0] = options.reversed_spring[1] = false;
  options.gain = 1;
  return options;
}

}  // namespace

TEST_CASE("a contact that only pushes is a spring on its penetrating side from its surface on") {
  for (const double outward : {1.0, -1.0}) {
    for (const double alpha : {1.0, 1.02}) {
      const AffineContact contact = wall(300, 0.05, outward);
      const DeviceSpring spring = device_spring(contact, alpha, 5);
      // F_a is 3 N at the tool. With alpha, the line through it meets zero 10 mm / alpha away.
      CHECK(spring.center_m.x == Approx(0.05 - outward * 0.01 * (1 - 1 / alpha)).epsilon(1e-12));
      CHECK(spring.below_N_per_m.x == (outward > 0 ? 300 * alpha : 0));
      CHECK(spring.above_N_per_m.x == (outward > 0 ? 0 : 300 * alpha));
      CHECK((spring.limit_N.x == 5 && spring.below_N_per_m.y == 0 && spring.limit_N.y == 0));
    }
  }
}

TEST_CASE("a bond is a spring on both sides and every axis for itself") {
  AffineContact bond;
  bond.tool_m = {0.01, -0.02, 0.03};
  bond.force_N = {1, 2, 0};
  bond.stiffness_N_per_m = {100, 200, 400, 0, 0, 0};
  const DeviceSpring spring = device_spring(bond, 1, 1e9);
  CHECK(spring.below_N_per_m == glm::dvec3(100, 200, 400));
  CHECK(spring.above_N_per_m == glm::dvec3(100, 200, 400));
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const auto draw = [&] { return static_cast<double>(random() % 2001) / 10'000 - 0.1; };
    const glm::dvec3 hand{draw(), draw(), draw()};
    const glm::dvec3 law = bond.force_N + bond.stiffness_N_per_m * (bond.tool_m - hand);
    // Room for some rounding of forces up to 50 N.
    for (int axis = 0; axis < 3; ++axis) REQUIRE(std::abs(force_N(spring, hand)[axis] - law[axis]) < 1e-12);
  }
}

TEST_CASE("of a bond with off-diagonal stiffness the springs are its diagonal, and the rest is what is missing to the law") {
  std::mt19937_64 random(3);
  const auto draw = [&](double size) { return (static_cast<double>(random() % 2001) / 1000 - 1) * size; };
  for (int i = 0; i < 1000; ++i) {
    AffineContact bond;
    bond.tool_m = {draw(0.01), draw(0.01), draw(0.01)};
    bond.force_N = {draw(2), draw(2), draw(2)};
    bond.stiffness_N_per_m = {300, 200, 100, draw(80), draw(80), draw(40)};
    const DeviceSpring spring = device_spring(bond, 1.1, 1e9);
    const glm::dvec3 hand{draw(0.01), draw(0.01), draw(0.01)};
    const glm::dvec3 law = LocalRenderer(1.1).force_N(bond, Duration{0}, hand);
    Symmetric beside = bond.stiffness_N_per_m;
    beside.xx = beside.yy = beside.zz = 0;
    const glm::dvec3 expected = beside * (bond.tool_m - hand) * 1.1, rest = law - force_N(spring, hand);
    for (int axis = 0; axis < 3; ++axis) REQUIRE(std::abs(rest[axis] - expected[axis]) < 1e-12);
  }
}

TEST_CASE("a contact that only pushes has its one spring along the axis nearest to its normal, and what pulls has none") {
  AffineContact contact = wall(300, 0.05, 1);
  contact.stiffness_N_per_m.yy = 1;
  contact.stiffness_N_per_m.xy = 1;
  CHECK(device_spring(contact, 1, 5).below_N_per_m == glm::dvec3(300, 0, 0));
  contact.outward = {-0.6, -0.8, 0};
  CHECK(device_spring(contact, 1, 5).above_N_per_m == glm::dvec3(0, 1, 0));
  CHECK(device_spring(contact, 1, 5).below_N_per_m == glm::dvec3(0));
  for (const double stiffness : {-300.0, 0.0, std::nan("")}) {
    const DeviceSpring none = device_spring(wall(stiffness, 0.05, 1), 1, 5);
    CHECK((none.below_N_per_m == glm::dvec3(0) && none.above_N_per_m == glm::dvec3(0)));
  }
}

TEST_CASE("the device renders the springs that the driver says it does for both flavours and every side") {
  std::mt19937_64 random(2);
  for (const PidFlavour flavour : kFlavours) {
    for (int i = 0; i < 300; ++i) {
      const auto draw = [&](double low, double high) {
        return low + static_cast<double>(random() >> 11) / (1ll << 53) * (high - low);
      };
      const glm::dvec3 at{draw(-0.2, 0.2), draw(-0.2, 0.2), 0};
      PidBench bench(pid_device(flavour), with_springs(), Still{at});
      bench.driver->start();
      bench.tick_at(0, {0, 0, 0});
      const DeviceSpring wanted{
          {draw(-0.2, 0.2), draw(-0.2, 0.2), 0}, {draw(0, 50), 0, 0}, {0, draw(0, 50), 0}, {draw(0, 10), draw(0, 10), 0}};
      const DeviceSpring rendered = bench.driver->write_spring(wanted);
      const double count = flavour == PidFlavour::mask ? 32767 : 10'000;
      for (int axis = 0; axis < 2; ++axis) {
        REQUIRE(std::abs(rendered.center_m[axis] - wanted.center_m[axis]) <= 0.2 / count * 0.5001);
        REQUIRE(std::abs(rendered.below_N_per_m[axis] - wanted.below_N_per_m[axis]) <= 50 / count * 0.5001);
        REQUIRE(std::abs(rendered.above_N_per_m[axis] - wanted.above_N_per_m[axis]) <= 50 / count * 0.5001);
        REQUIRE(std::abs(rendered.limit_N[axis] - wanted.limit_N[axis]) <= 10 / count * 0.5001);
        // The firmware computes in its own way; the result is the same up to rounding.
        REQUIRE(std::abs(bench.device.force_N()[axis] - force_N(rendered, at)[axis]) < 1e-12);
      }
    }
  }
}

TEST_CASE("a spring steeper than the device can is split and the rest is left to the loop") {
  // 10 N over half of 0.4 m: 50 N/m at full gain.
  for (const double gain : {1.0, 0.2}) {
    PidOptions options = with_springs();
    options.gain = gain;
    PidBench bench(pid_device(PidFlavour::mask), options, Still{{0.045, 0, 0}});
    bench.driver->start();
    bench.tick_at(0, {0, 0, 0});
    const AffineContact contact = wall(300, 0.05, 1);
    const DeviceSpring rendered = bench.driver->write_spring(device_spring(contact, 1, 10));
    CHECK(rendered.below_N_per_m.x == Approx(50 * gain).margin(50.0 / 32767));
    const glm::dvec3 hand{0.045, 0, 0};
    const glm::dvec3 rest = LocalRenderer(1).force_N(contact, Duration{0}, hand) - force_N(rendered, hand);
    CHECK(rest.x == Approx(1.5 - 50 * gain * 0.005).epsilon(1e-3));
    bench.driver->write(rest);
    // Up to a count of the force and a count of the center, which is 6 um.
    CHECK(bench.device.force_N().x == Approx(1.5).margin(1e-3));
  }
  PidOptions measured = with_springs();
  measured.full_slope_N_per_m = glm::dvec3(1000, 1000, 1000);
  PidBench bench(pid_device(PidFlavour::mask), measured);
  bench.driver->start();
  bench.tick_at(0, {0, 0, 0});
  CHECK(bench.driver->write_spring(device_spring(wall(300, 0.05, 1), 1, 10)).below_N_per_m.x == Approx(300).epsilon(1e-4));
}

TEST_CASE("a device renders no spring that it has no field for") {
  using Options = PidDescriptorOptions;
  const DeviceSpring one_sided{{0.05, 0, 0}, {20, 0, 0}, {0, 0, 0}, {5, 0, 0}};
  const DeviceSpring both_sided{{0.05, 0, 0}, {20, 0, 0}, {20, 0, 0}, {10, 10, 0}};
  const DeviceSpring centered{{0, 0, 0}, {20, 0, 0}, {20, 0, 0}, {10, 10, 0}};
  const auto rendered = [](bool Options::*part, const DeviceSpring& wanted) {
    SimulatedPidOptions device = pid_device(PidFlavour::mask);
    if (part) device.descriptor.*part = false;
    PidOptions options = with_springs();
    options.travel_m.y = 0;
    PidBench bench(device, options);
    bench.driver->start();
    bench.tick_at(0, {0, 0, 0});
    const DeviceSpring spring = bench.driver->write_spring(wanted);
    return spring.below_N_per_m.x > 0 || spring.above_N_per_m.x > 0;
  };
  const DeviceSpring other_side{{0.05, 0, 0}, {0, 0, 0}, {20, 0, 0}, {5, 0, 0}};
  CHECK(rendered(nullptr, one_sided));
  CHECK(rendered(nullptr, other_side));
  CHECK_FALSE(rendered(&Options::negative_coefficient, other_side));
  CHECK_FALSE(rendered(&Options::negative_coefficient, one_sided));
  CHECK(rendered(&Options::negative_coefficient, both_sided));
  CHECK_FALSE(rendered(&Options::center, both_sided));
  CHECK(rendered(&Options::center, centered));
  CHECK_FALSE(rendered(&Options::saturation, one_sided));  // its limit lies below the device's own
  CHECK(rendered(&Options::saturation, both_sided));
  CHECK(rendered(&Options::negative_saturation, one_sided));
  CHECK(rendered(&Options::parameter_block, one_sided));
  CHECK(rendered(&Options::dead_band, one_sided));
  DeviceSpring outside = one_sided;
  outside.center_m.x = 0.21;
  CHECK_FALSE(rendered(nullptr, outside));
}

TEST_CASE("without the option for springs nothing is created for them and none is rendered") {
  PidBench bench(pid_device(PidFlavour::mask));
  bench.driver->start();
  CHECK(bench.device.allocated() == 2);
  bench.tick_at(0, {0, 0, 0});
  const DeviceSpring rendered = bench.driver->write_spring({{0, 0, 0}, {1, 1, 0}, {1, 1, 0}, {1, 1, 0}});
  CHECK((rendered.below_N_per_m == glm::dvec3(0) && rendered.above_N_per_m == glm::dvec3(0)));
}

TEST_CASE("a condition is sent when it changes and with the refresh") {
  PidOptions options = with_springs();
  options.travel_m.y = 0;
  PidBench bench(pid_device(PidFlavour::mask), options);
  bench.driver->start();
  CHECK(bench.device.playing() == 2);
  bench.tick_at(0, {0, 0, 0});
  bench.transport.log.clear();
  // Each value is half of its range: center 0.1 of 0.2 m, stiffness below 25 of 50 N/m, limit 5 of 10 N.
  const DeviceSpring spring{{0.1, 0, 0}, {25, 0, 0}, {0, 0, 0}, {5, 0, 0}};
  for (int i = 0; i < 3; ++i) bench.driver->write_spring(spring);
  CHECK(bench.transport.log == std::vector<std::string>{"w 12 02 00 00 40 00 00 00 40 00 40 00 40 00 00"});
  bench.transport.log.clear();
  bench.tick_at(250 * kMs, {0, 0, 0});
  CHECK(bench.transport.log == std::vector<std::string>{"w 14 01 00 00", "w 16 01 01 01",
                                                        "w 12 02 00 00 40 00 00 00 40 00 40 00 40 00 00", "w 16 02 01 01"});
}

TEST_CASE("a hand comes to rest on the device's own wall and the wall goes when the host hangs") {
  HandSpec spec;
  spec.damping_N_s_per_m = 5;
  spec.push_N = {-1, 0, 0};
  SimulatedPidOptions device = pid_device(PidFlavour::mask);
  device.reports.queue = QueuePolicy::libusb;  // the newest position after the pause
  PidBench bench(device, with_springs(), Hand(spec, {Still{}, RealTime{}}));
  bench.clock.wait_until(RealTime{200 * kMs});  // the firmware's time begins with the spring, not with the clock
  bench.driver->start();
  const DeviceSpring wall_spring{{0.02, 0, 0}, {40, 0, 0}, {0, 0, 0}, {10, 0, 0}};
  DeviceSample sample;
  for (std::int64_t tick = 200; tick < 3000; ++tick) {
    sample = bench.tick_at(tick * kMs, {0, 0, 0});
    bench.driver->write_spring(wall_spring);
  }
  // 1 N against 40 N/m from 20 mm on. A count of the position is 6 um.
  CHECK(sample.position_m.x == Approx(0.02 - 0.025).margin(1e-5));
  bench.clock.wait_until(RealTime{3600 * kMs});
  CHECK(bench.driver->read(bench.clock.now()).position_m.x < -0.02);
  CHECK(bench.device.playing() == 0);
}
