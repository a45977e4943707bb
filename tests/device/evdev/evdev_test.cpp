// The driver of Linux' force feedback devices (evdev), on a simulated one.

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "catch.h"
#include "evdev_bench.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/evdev/evdev_driver.h"
#include "evenstep/device/evdev/simulated_evdev.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

constexpr Duration kTick{1'000'000};

struct SimulatedEvdevBench {
  explicit SimulatedEvdevBench(SimulatedEvdevOptions options = {}, const Motion& motion = Still{},
                               const EvdevOptions& own = evdev_options())
      : device(clock, ProgrammedMotion{motion, RealTime{}}, std::move(options)), driver(device, own) {}
  DeviceSample tick(const glm::dvec3& force_N) {
    clock.wait_until(clock.now() + kTick);
    const DeviceSample sample = driver.read(clock.now());
    driver.write(force_N);
    return sample;
  }
  void ticks(int count, const glm::dvec3& force_N) {
    for (int i = 0; i < count; ++i) tick(force_N);
  }
  /// True within two counts of a level: one for rounding, one that a refresh may take away.
  bool renders(const glm::dvec3& force_N) { return glm::length(device.force_N() - force_N) < 2 * 10.0 / 0x7FFF; }

  VirtualClock clock;
  SimulatedEvdev device;
  EvdevDriver driver;
};

ReportFault fault(ReportFault::Kind kind, std::int64_t tick, std::int64_t amount) { return {kind, tick, amount}; }

}  // namespace

TEST_CASE("evdev: a force along each axis is rendered in its direction and nothing is left after stop") {
  SimulatedEvdevBench bench;
  bench.driver.start();
  for (const glm::dvec3 force_N :
       {glm::dvec3{1.5, 0, 0}, {-1.5, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0.5, -0.25, 0}, {10, 10, 0}}) {
    bench.ticks(5, force_N);
    CHECK(bench.renders(force_N));
  }
  CHECK(bench.device.motors().effects_playing == 2);
  bench.driver.stop();
  const MotorState left = bench.device.motors();
  CHECK(left.effects_playing == 0);
  CHECK(left.effects_allocated == 0);
  CHECK(left.force_N == glm::dvec3(0));
}

TEST_CASE("evdev: no force beyond the share that may be used is rendered and each is counted") {
  EvdevOptions options = evdev_options();
  options.gain = 0.25;
  SimulatedEvdevBench bench({}, Still{}, options);
  bench.driver.start();
  bench.ticks(7, {100, -100, 0});
  CHECK(bench.renders({2.5, -2.5, 0}));
  CHECK(bench.driver.largest_force_N() == 2.5);
  CHECK(bench.driver.evdev_counters().saturated == 7);
}

TEST_CASE("evdev: a device that pushes the other way is sent the other sign") {
  EvdevOptions options = evdev_options();
  options.reversed_force = {true, true};
  SimulatedEvdevBench bench({}, Still{}, options);
  bench.driver.start();
  bench.ticks(5, {1, 2, 0});
  CHECK(bench.renders({-1, -2, 0}));
}

TEST_CASE("evdev: positions are within half a count of the hand and are not smoothed by the kernel") {
  // 2 mm/s: 0.16 counts a tick, far below the fuzz of 255 counts.
  const ConstantVelocity motion{{0.002, -0.002, 0}, Duration{0}, {0, 0, 0}};
  SimulatedEvdevBench bench({}, motion);
  bench.driver.start();
  double worst_m = 0;
  for (int i = 0; i < 2000; ++i) {
    const DeviceSample sample = bench.tick({});
    worst_m = std::max(worst_m, glm::length(sample.position_m - position_m(motion, bench.clock.now())));
  }
  CHECK(worst_m <= 0.5001 * std::sqrt(2.0) * 0.4 / 65534);
}

TEST_CASE("evdev: a hand that nobody read for longer than the buffer holds is found where it is, not where it was") {
  SimulatedEvdevOptions options;
  for (std::int64_t tick = 100; tick < 200; ++tick)
    options.reports.faults.push_back(fault(ReportFault::Kind::unread, tick, 1));
  const ConstantVelocity motion{{0.1, 0, 0}};
  SimulatedEvdevBench bench(options, motion);
  bench.driver.start();
  std::int64_t before = 0;
  for (int tick = 1; tick < 300; ++tick) {
    const DeviceSample sample = bench.tick({});
    if (tick == 199) before = bench.driver.counters().reports;
    if (tick < 100 || tick >= 200) CHECK(std::abs(sample.position_m.x - 0.1e-3 * tick) < 0.4 / 65534);
  }
  CHECK(bench.driver.evdev_counters().dropped == 1);
  CHECK(before == 99);
}

TEST_CASE("evdev: of what came before the run nothing is lost and nothing is counted, however much it was") {
  for (const int waited_ms : {1, 10, 100, 500}) {
    for (const bool forgets : {true, false}) {
      INFO(waited_ms << " ms" << (forgets ? "" : ", not forgotten"));
      EvdevOptions own = evdev_options();
      own.unchanged_age = Duration{2 * kTick.ns};
      SimulatedEvdevBench bench({}, ConstantVelocity{{0.02, 0.01, 0}}, own);
      bench.driver.start();
      bench.clock.wait_until(RealTime{waited_ms * kTick.ns});
      if (forgets) bench.driver.forget_queued();
      bench.clock.wait_until(bench.clock.now() + Duration{kTick.ns / 2});  // as the device lane does before its first tick
      const DeviceSample first = bench.driver.read(bench.clock.now());
      const double at_s = waited_ms * 1e-3;
      CHECK(first.fresh);
      CHECK(first.position_m.x == Approx(0.02 * at_s).margin(0.4 / 65534));
      CHECK(first.position_m.y == Approx(0.01 * at_s).margin(0.4 / 65534));
      REQUIRE(first.taken_at);
      CHECK(*first.taken_at <= first.read_at);
      CHECK(first.read_at - *first.taken_at <= Duration{2 * kTick.ns});
      // Each tick sends two axes and SYN_REPORT, so the buffer of 64 places is full after some 22 ms.
      CHECK(bench.driver.evdev_counters().dropped == (!forgets && waited_ms >= 100));
      if (forgets) CHECK(bench.driver.counters().reports == 0);
      const DeviceSample second = bench.tick(glm::dvec3(0));
      CHECK(second.fresh);
      CHECK(second.position_m.x == Approx(0.02 * (at_s + 1e-3)).margin(0.4 / 65534));
      CHECK(second.taken_at > first.taken_at);
    }
  }
}

TEST_CASE("evdev: what comes between SYN_DROPPED and the next SYN_REPORT is not believed") {
  ScriptedNode node;
  EvdevOptions options = evdev_options();
  options.travel_m = {0.2, 0, 0};
  EvdevDriver driver(node, options);
  const auto x_after = [&](std::vector<EvdevEvent> events, std::int64_t at) {
    node.events = std::move(events);
    return driver.read(RealTime{at}).position_m.x;
  };
  const EvdevEvent end{evdev::kSyn, evdev::kSynReport, 0}, dropped{evdev::kSyn, evdev::kSynDropped, 0};
  CHECK(x_after({{evdev::kAbs, 0, 50}, end}, 1) == Approx(0.05));
  CHECK(x_after({{evdev::kAbs, 0, 60}}, 2) == Approx(0.05));  // the report is not complete yet
  CHECK(x_after({end}, 3) == Approx(0.06));
  node.x = -20;
  CHECK(x_after({dropped, {evdev::kAbs, 0, 90}}, 4) == Approx(0.06));
  CHECK(x_after({{evdev::kAbs, 0, 80}, end}, 5) == Approx(-0.02));
  // MSC_TIMESTAMP, keys, other axes, force feedback status; values far outside the range.
  CHECK(x_after({{4, 5, 1234}, {1, 0x120, 1}, {evdev::kAbs, 1, 77}, {0x17, 0, 1}, end}, 6) == Approx(-0.02));
  CHECK(x_after({{evdev::kAbs, 0, std::numeric_limits<std::int32_t>::max()}, end}, 7) == Approx(0.1));
  CHECK(x_after({{evdev::kAbs, 0, std::numeric_limits<std::int32_t>::min()}, end}, 8) == Approx(-0.1));
}

TEST_CASE("evdev: a hand that moves no count is still for a second and then not reported") {
  SimulatedEvdevBench bench;
  bench.driver.start();
  for (int tick = 1; tick <= 1500; ++tick) CHECK(bench.tick({}).fresh == (tick <= 1001));
}

TEST_CASE("evdev: an axis that has told nothing yet and whose 0 is its end has no position") {
  SimulatedEvdevOptions options;
  options.minimum = 0;
  options.maximum = 4095;
  options.reports.first_tick = RealTime{10'000'000};  // the device is powered on after it was opened
  SimulatedEvdevBench bench(options);
  bench.driver.start();
  for (int tick = 1; tick < 20; ++tick) {
    const DeviceSample sample = bench.tick({});
    CHECK(sample.fresh == (tick >= 10));
    if (tick >= 10) CHECK(std::abs(sample.position_m.x) < 0.4 / 4095);
  }
}

TEST_CASE("evdev: effects end by themselves when the host writes no more") {
  SimulatedEvdevBench bench;
  bench.driver.start();
  bench.ticks(10, {1, 0, 0});
  CHECK(bench.renders({1, 0, 0}));
  bench.clock.wait_until(bench.clock.now() + Duration{499'000'000});
  bench.driver.read(bench.clock.now());
  CHECK(bench.device.force_N() == glm::dvec3(0));
  bench.ticks(5, {1, 0, 0});
  CHECK(bench.renders({1, 0, 0}));
}

TEST_CASE("evdev: another program that stops the effects and turns the gain down is overruled after half of a duration") {
  SimulatedEvdevOptions options;
  options.meddled_at = RealTime{1'000'000'000};
  SimulatedEvdevBench bench(options);
  bench.driver.start();
  int wrong = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    bench.tick({1, 0, 0});
    if (tick > 5 && !bench.renders({1, 0, 0})) ++wrong;
  }
  CHECK(wrong > 0);
  CHECK(wrong <= 252);
}

TEST_CASE(
    "evdev: a force whose upload is lost on the cable is made up for in half of a duration although it stays the same") {
  for (const double after_N : {0.0, 2.0}) {
    SimulatedEvdevOptions options;
    // Lost are the upload of tick 600 and the gain, plays and uploads that could follow within 20 ms.
    options.reports.faults = {fault(ReportFault::Kind::write_lost, 600, 1)};
    EvdevOptions own = evdev_options();
    own.travel_m.y = 0;
    SimulatedEvdevBench bench(options, Still{}, own);
    bench.driver.start();
    int wrong = 0;
    for (int tick = 1; tick < 2000; ++tick) {
      const double force_N = tick < 600 ? 5 : after_N;
      bench.tick({force_N, 0, 0});
      if (tick > 5 && !bench.renders({force_N, 0, 0})) ++wrong;
    }
    CHECK(wrong > 10);
    CHECK(wrong <= 252);
  }
}

TEST_CASE("evdev: a device that refuses its first effects twice is used, one that refuses three times is not") {
  struct Reluctant : ScriptedNode {
    int refusals = 0;
    int upload(EvdevEffect& effect) override { return refusals-- > 0 ? EIO : ScriptedNode::upload(effect); }
  };
  Reluctant node;
  EvdevOptions options = evdev_options();
  options.travel_m = {0.2, 0, 0};
  EvdevDriver driver(node, options);
  node.refusals = 2;
  driver.start();
  CHECK_FALSE(node.uploads.empty());
  driver.stop();
  node.refusals = 3;
  CHECK_THAT(device_error_of([&] { driver.start(); }), Contains("it refuses a constant force"));
}

TEST_CASE("evdev: an upload that is refused is repeated, and a device that refuses for ever ends the run") {
  SimulatedEvdevOptions options;
  options.reports.faults = {fault(ReportFault::Kind::write_rejected, 100, 3)};
  SimulatedEvdevBench bench(options);
  bench.driver.start();
  bench.ticks(99, {1, 0, 0});
  bench.ticks(10, {2, 0, 0});
  CHECK(bench.renders({2, 0, 0}));
  CHECK(bench.driver.counters().write_failures == 3);

  options.reports.faults = {fault(ReportFault::Kind::write_rejected, 100, 1'000'000)};
  SimulatedEvdevBench broken(options);
  broken.driver.start();
  std::int64_t ended = 0;
  const std::string error = device_error_of([&] {
    for (int tick = 1; tick < 2000; ++tick) ended = tick, broken.tick({tick * 1e-3, 0, 0});
  });
  CHECK_THAT(error, Contains("has refused an effect for 500 ms; if it still pushes, switch it off"));
  CHECK(ended <= 604);
}

TEST_CASE("evdev: no more is sent than the device takes, axes take turns, and the newest force overtakes") {
  EvdevOptions options = evdev_options();
  options.update_rate = {250, 1};
  SimulatedEvdevBench bench({}, Still{}, options);
  bench.driver.start();
  double last_x = 0, last_y = 0;
  std::vector<int> gaps_x, gaps_y;
  int gap_x = 0, gap_y = 0;
  for (int tick = 1; tick <= 1000; ++tick) {
    bench.tick({tick * 1e-3, tick * -2e-3, 0});
    const glm::dvec3 now_N = bench.device.force_N();
    ++gap_x, ++gap_y;
    if (now_N.x != last_x) gaps_x.push_back(gap_x), gap_x = 0;
    if (now_N.y != last_y) gaps_y.push_back(gap_y), gap_y = 0;
    last_x = now_N.x, last_y = now_N.y;
  }
  // 250 writes a second for two axes. Two of them in 250 ms are plays.
  CHECK(gaps_x.size() + gaps_y.size() >= 235);
  CHECK(gaps_x.size() + gaps_y.size() <= 250);
  CHECK(*std::max_element(gaps_x.begin() + 1, gaps_x.end()) <= 20);
  CHECK(*std::max_element(gaps_y.begin() + 1, gaps_y.end()) <= 20);
  CHECK(bench.driver.evdev_counters().waited > 900);
}

TEST_CASE("evdev: a spring pulls to its center on the side that was asked for") {
  EvdevOptions options = evdev_options();
  options.springs = true;
  options.reversed_spring = {false, false};
  SimulatedEvdevBench bench({}, Still{{0.05, -0.02, 0}}, options);
  bench.driver.start();
  DeviceSpring spring;
  spring.center_m = {0.01, 0.02, 0};
  spring.above_N_per_m = {10, 0, 0};
  spring.below_N_per_m = {0, 5, 0};
  spring.limit_N = {2, 2, 0};
  DeviceSpring rendered;
  for (int tick = 0; tick < 20; ++tick) {
    bench.tick({});
    rendered = bench.driver.write_spring(spring);
  }
  CHECK(glm::length(bench.device.force_N() - glm::dvec3{-0.4, 0.2, 0}) < 2e-3);
  CHECK(rendered.above_N_per_m.x == Approx(10).margin(0.01));
  CHECK(rendered.below_N_per_m.y == Approx(5).margin(0.01));
  CHECK(rendered.limit_N.x == Approx(2).margin(1e-3));
  spring.limit_N = {0.1, 0.1, 0};
  for (int tick = 0; tick < 20; ++tick) bench.tick({}), bench.driver.write_spring(spring);
  CHECK(glm::length(bench.device.force_N() - glm::dvec3{-0.1, 0.1, 0}) < 2e-3);
}

TEST_CASE("evdev: along an axis whose spring has no known sign there is none") {
  EvdevOptions options = evdev_options();
  options.springs = true;
  SimulatedEvdevBench bench({}, Still{}, options);
  bench.driver.start();
  CHECK(bench.device.motors().effects_allocated == 2);
  DeviceSpring spring;
  spring.above_N_per_m = spring.below_N_per_m = {10, 10, 0};
  spring.limit_N = {1, 1, 0};
  bench.tick({});
  CHECK(bench.driver.write_spring(spring).above_N_per_m == glm::dvec3(0));
}

TEST_CASE("evdev: a device without room says how much it has, and nothing of ours is left on it") {
  SimulatedEvdevOptions options;
  options.effects = 4;
  options.foreign_effects = 3;
  SimulatedEvdevBench bench(options);
  CHECK_THAT(device_error_of([&] { bench.driver.start(); }), Contains("no room for effect 2: the device has room for 4"));
  CHECK(bench.device.motors().effects_allocated == 0);
}

TEST_CASE("evdev: a device that another program has for itself is refused") {
  SimulatedEvdevOptions options;
  options.held = true;
  CHECK_THAT(device_error_of([&] { SimulatedEvdevBench bench(options); }),
             Contains("another program has the device for itself (EVIOCGRAB)"));
}

TEST_CASE("evdev: a device that is unplugged while it plays is an error and stop is quiet") {
  SimulatedEvdevOptions options;
  options.reports.unplug_at_tick = 50;
  SimulatedEvdevBench bench(options);
  bench.driver.start();
  CHECK_THAT(device_error_of([&] { bench.ticks(100, {1, 0, 0}); }), Contains("device 'evenstep evdev device' is gone"));
  bench.driver.stop();
  CHECK(bench.device.motors().force_N == glm::dvec3(0));
}

TEST_CASE("evdev: options that make no sense and axes that are not there are refused") {
  const auto refused = [](auto change) {
    EvdevOptions options = evdev_options();
    change(options);
    return device_error_of([&] { SimulatedEvdevBench bench({}, Still{}, options); });
  };
  CHECK_THAT(refused([](auto& o) { o.gain = 0; }), Contains("gain is 0"));
  CHECK_THAT(refused([](auto& o) { o.travel_m.z = 0.1; }), Contains("axis Z has a travel, but the device has no such axis"));
  CHECK_THAT(refused([](auto& o) { o.travel_m = {0, 0, 0}; }), Contains("no axis has a travel"));
  CHECK_THAT(refused([](auto& o) { o.full_scale_N = -1; }), Contains("full_scale_N is -1"));
  CHECK_THAT(refused([](auto& o) { o.effect_duration = Duration{33'000'000'000}; }), Contains("effect_duration must be"));
  EvdevOptions springs = evdev_options();
  springs.springs = true;
  SimulatedEvdevOptions without;
  without.springs = false;
  CHECK_THAT(device_error_of([&] { SimulatedEvdevBench bench(without, Still{}, springs); }),
             Contains("plays no springs (FF_SPRING)"));
}

TEST_CASE("evdev: without a full scale nothing is uploaded and a force is an error") {
  EvdevOptions options = evdev_options();
  options.full_scale_N.reset();
  SimulatedEvdevBench bench({}, Still{}, options);
  bench.driver.start();
  CHECK(bench.device.motors().effects_allocated == 0);
  CHECK_THAT(device_error_of([&] { bench.tick({}); }), Contains("a force cannot be written"));
}

// ---- the simulated device behaves as the kernel does

TEST_CASE("simulated evdev: an effect belongs to who uploaded it, keeps its type, and its number is given again") {
  VirtualClock clock;
  SimulatedEvdevOptions options;
  options.effects = 3;
  options.foreign_effects = 1;
  SimulatedEvdev device(clock, ProgrammedMotion{}, options);
  EvdevEffect a, b, c;
  CHECK(device.upload(a) == 0);
  CHECK(a.id == 1);
  b.type = evdev::kSpring;
  CHECK(device.upload(b) == 0);
  CHECK(b.id == 2);
  CHECK(device.upload(c) == ENOSPC);
  CHECK(c.id == -1);
  EvdevEffect changed = a;
  changed.type = evdev::kSpring;
  CHECK(device.upload(changed) == EINVAL);
  changed = a;
  changed.id = 0;
  CHECK(device.upload(changed) == EACCES);
  changed.id = 3;
  CHECK(device.upload(changed) == EINVAL);
  CHECK(device.erase(0) == EACCES);
  CHECK(device.erase(7) == EINVAL);
  CHECK(device.erase_as_other(a.id) == EACCES);
  CHECK(device.erase(a.id) == 0);
  CHECK(device.erase(a.id) == EINVAL);
  CHECK(device.upload(c) == 0);
  CHECK(c.id == 1);
  EvdevEffect rumble;
  rumble.type = 0x50;
  CHECK(device.upload(rumble) == EINVAL);
}

TEST_CASE("simulated evdev: the buffer of 64 places keeps the newest event and says that others are gone") {
  VirtualClock clock;
  SimulatedEvdevOptions options;
  options.fuzz = 0;
  SimulatedEvdev device(clock, ProgrammedMotion{ConstantVelocity{{0.1, 0, 0}}, RealTime{}}, options);
  // From the second report on there are two events a report, so 31 reports fit and the 32nd fills the last place.
  clock.wait_until(RealTime{31'000'000});
  std::array<EvdevEvent, 128> events;
  CHECK(device.read(events).count == 62);
  clock.wait_until(RealTime{63'000'000});
  const EvdevRead got = device.read(events);
  REQUIRE(got.count == 2);
  CHECK(events[0].code == evdev::kSynDropped);
  CHECK(events[1].code == evdev::kSynReport);
}
