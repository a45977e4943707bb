/// The driver of Linux' force feedback devices on the kernel's own input core, with a device behind /dev/uinput.

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "../device/evdev/evdev_bench.h"
#include "catch.h"
#include "evenstep/device/evdev/evdev_driver.h"
#include "evenstep/device/evdev/evdev_file.h"
#include "evenstep/device/evdev/live_evdev.h"
#include "kernel_bench.h"
#include "uinput_device.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

struct Bench {
  explicit Bench(const EvdevOptions& options = evdev_options()) : file(device.node()), driver(file, options) {}
  DeviceSample tick(const glm::dvec3& force_N) {
    const DeviceSample sample = driver.read(a_clock().now());
    driver.write(force_N);
    return sample;
  }
  UinputDevice device;
  EvdevFile file;
  EvdevDriver driver;
};

}  // namespace

TEST_CASE("evdev on the kernel: forces are uploaded, played, changed and erased") {
  Bench bench;
  bench.driver.start();
  REQUIRE(bench.device.told().effects.size() == 2);
  const auto has = [&](int x, int y) {
    const UinputDevice::Told told = bench.device.told();
    const ff_effect &along_x = told.effects.at(0), &along_y = told.effects.at(1);
    CHECK(along_x.type == FF_CONSTANT);
    CHECK(along_x.direction == 0x4000);
    CHECK(along_y.direction == 0);
    CHECK(along_x.replay.length == 500);
    const auto near = [](int level, int wanted) { return std::abs(level - wanted) <= 1; };
    return near(along_x.u.constant.level, x) && near(along_y.u.constant.level, y) && told.plays.count(0) &&
           told.plays.count(1) && told.plays.at(0) == 1 && told.plays.at(1) == 1;
  };
  // 10 N are 32767. Left is lower X, and down is higher Y.
  REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), has(-3277, 0); }));
  REQUIRE(eventually([&] { return bench.tick({-2, 5, 0}), has(6553, 16384); }));
  REQUIRE(eventually([&] { return bench.tick({10, -10, 0}), has(-32767, -32767); }));
  CHECK(bench.device.told().gain == 0xFFFF);
  CHECK(bench.device.told().autocenter == 0);
  CHECK(bench.driver.counters().write_failures == 0);
  bench.driver.stop();
  CHECK(bench.device.told().effects.empty());
  REQUIRE(eventually([&] { return bench.device.told().plays.at(0) == 0 && bench.device.told().plays.at(1) == 0; }));
}

TEST_CASE("evdev on the kernel: springs reach the device as conditions of their axis") {
  EvdevOptions options = evdev_options();
  options.springs = true;
  options.reversed_spring = {false, true};
  Bench bench(options);
  bench.driver.start();
  DeviceSpring spring;
  spring.center_m = {0.05, -0.1, 0};
  spring.above_N_per_m = {25, 5, 0};
  spring.below_N_per_m = {0, 10, 0};
  spring.limit_N = {5, 2, 0};
  REQUIRE(eventually([&] {
    bench.tick({});
    bench.driver.write_spring(spring);
    const auto effects = bench.device.told().effects;
    const ff_condition_effect &x = effects.at(2).u.condition[0], &y = effects.at(3).u.condition[1];
    return x.right_coeff == 16384 && x.left_coeff == 0 && x.center == 8192 && x.right_saturation == 32768 &&
           y.right_coeff == -3277 && y.left_coeff == -6553 && y.center == -16384;
  }));
}

TEST_CASE("evdev on the kernel: positions are exact although the axis had a fuzz, which is back afterwards") {
  UinputDevice device;
  EvdevFile look(device.node());
  {
    EvdevFile file(device.node());
    EvdevDriver driver(file, evdev_options());
    for (const int count : {1000, 1001, 1003, 1010, 900, -32767, 32767}) {
      device.report(count, -count);
      REQUIRE(eventually([&] {
        const DeviceSample sample = driver.read(a_clock().now());
        return std::abs(sample.position_m.x - 0.2 * count / 32767) < 1e-9 &&
               std::abs(sample.position_m.y + 0.2 * count / 32767) < 1e-9;
      }));
    }
    EvdevAxis axis;
    REQUIRE(look.axis(0, axis) == 0);
    CHECK(axis.fuzz == 0);
  }
  EvdevAxis axis;
  REQUIRE(look.axis(0, axis) == 0);
  CHECK(axis.fuzz == UinputDevice::kFuzz);
}

TEST_CASE("evdev on the kernel: when the buffer was full the driver asks where the hand is") {
  Bench bench;
  for (int count = 1; count <= 500; ++count) bench.device.report(count, -count);
  const DeviceSample sample = bench.driver.read(a_clock().now());
  CHECK(bench.driver.evdev_counters().dropped >= 1);
  CHECK(sample.position_m.x == Approx(0.2 * 500 / 32767));
  bench.device.report(600, 0);
  REQUIRE(eventually([&] { return std::abs(bench.driver.read(a_clock().now()).position_m.x - 0.2 * 600 / 32767) < 1e-9; }));
}

TEST_CASE("evdev on the kernel: a sample was taken when the kernel got its event, between the two ends of the report") {
  EvdevOptions options = evdev_options();
  options.unchanged_age = Duration{2'000'000};
  UinputDevice device;
  LiveEvdev live(
      std::make_unique<EvdevFile>(device.node()), [] { return EvdevNodes(); }, a_clock());
  EvdevDriver driver(live, options);
  REQUIRE(live.tells_times());
  constexpr Duration kMicrosecond{1000};  // times of events are whole microseconds
  for (int count = 1; count <= 200; ++count) {
    const RealTime before = a_clock().now();
    device.report(100 * count, 0);
    const RealTime after = a_clock().now();
    // Reads are late by up to some milliseconds. That makes the sample older, but does not change its time.
    std::this_thread::sleep_for(std::chrono::microseconds(37 * (count % 90)));
    DeviceSample sample;
    REQUIRE(eventually([&] {
      sample = driver.read(a_clock().now());
      return std::abs(sample.position_m.x - 0.2 * 100 * count / 32767) < 1e-9;
    }));
    REQUIRE(sample.taken_at);
    CHECK(*sample.taken_at > before - kMicrosecond);
    CHECK(*sample.taken_at <= after);
  }
  CHECK(driver.ages()->ages.count() == 200);
  CHECK((driver.ages()->ahead == 0 && driver.ages()->capped == 0));
  // No event comes while the hand holds still, but its position stays valid.
  const RealTime last = *driver.read(a_clock().now()).taken_at;
  settle();
  const DeviceSample still = driver.read(a_clock().now());
  CHECK((still.fresh && still.taken_at > last && still.read_at - *still.taken_at == *options.unchanged_age));
}

TEST_CASE("evdev on the kernel: a second program that has the device, or its room, is told of") {
  UinputDevice device;
  {
    EvdevFile other(device.node());
    REQUIRE(other.grab() == 0);
    EvdevFile file(device.node());
    CHECK_THAT(device_error_of([&] { EvdevDriver driver(file, evdev_options()); }),
               Contains("another program has the device for itself"));
  }
  EvdevFile other(device.node());
  EvdevEffect theirs;
  for (int i = 0; i < UinputDevice::kEffects - 1; ++i) {
    theirs.id = -1;
    REQUIRE(other.upload(theirs) == 0);
  }
  EvdevFile file(device.node());
  EvdevDriver driver(file, evdev_options());
  CHECK_THAT(device_error_of([&] { driver.start(); }), Contains("no room for effect 2: the device has room for 4"));
  CHECK(device.told().effects.size() == UinputDevice::kEffects - 1);
  CHECK(file.erase(theirs.id) == EACCES);
  CHECK(file.upload(theirs) == EACCES);
  theirs.type = evdev::kSpring;
  CHECK(other.upload(theirs) == EINVAL);
}

TEST_CASE("evdev on the kernel: what another program does to gain and effects is overruled, and its writes pass our grab") {
  Bench bench;
  bench.driver.start();
  REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.device.told().plays.count(0) != 0; }));
  EvdevFile other(bench.device.node());
  CHECK(other.grab() == EBUSY);
  REQUIRE(other.write({evdev::kFf, 0, 0}) == 0);
  REQUIRE(other.write({evdev::kFf, evdev::kGain, 0}) == 0);
  REQUIRE(eventually([&] { return bench.device.told().plays.at(0) == 0 && bench.device.told().gain == 0; }));
  REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.device.told().gain == 0xFFFF; }));
  REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.device.told().plays.at(0) == 1; }));
}

TEST_CASE("evdev on the kernel: a refused upload is repeated, and the effects of a program that dies are erased") {
  Bench bench;
  bench.driver.start();
  bench.device.refuse(EIO);
  REQUIRE(eventually([&] { return bench.tick({2, 0, 0}), bench.driver.counters().write_failures > 0; }));
  bench.device.refuse(0);
  REQUIRE(eventually([&] {
    bench.tick({2, 0, 0});
    return std::abs(bench.device.told().effects.at(0).u.constant.level + 6553) <= 1;
  }));
  {
    EvdevFile dying(bench.device.node());
    EvdevEffect effect;
    REQUIRE(dying.upload(effect) == 0);
    CHECK(bench.device.told().effects.size() == 3);
  }
  CHECK(bench.device.told().effects.size() == 2);
}

TEST_CASE("evdev on the kernel: a device that is unplugged while it plays is an error and stop is quiet") {
  Bench bench;
  bench.driver.start();
  REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.device.told().plays.count(0) != 0; }));
  bench.device.unplug();
  std::string error;
  REQUIRE(eventually([&] { return !(error = device_error_of([&] { bench.tick({1, 0, 0}); })).empty(); }));
  CHECK_THAT(error, Contains("device 'evenstep uinput device' is gone"));
  bench.driver.stop();
}

TEST_CASE("evdev on the kernel: a device that was unplugged is found by what it is, has its effects anew and plays them") {
  UinputDevice device;
  auto file = std::make_unique<EvdevFile>(device.node());
  const EvdevInfo info = file->info();
  LiveEvdev live(
      std::move(file), [info] { return open_again(info); }, a_clock(), Duration{10'000'000'000});
  EvdevDriver driver(live, evdev_options());
  const auto tick = [&](const glm::dvec3& force_N) {
    const DeviceSample sample = driver.read(a_clock().now());
    driver.write(force_N);
    return sample;
  };
  const auto plays = [&](int level) {
    const UinputDevice::Told told = device.told();
    return told.effects.size() == 2 && std::abs(told.effects.at(0).u.constant.level - level) <= 1 && told.plays.count(0) &&
           told.plays.at(0) == 1;
  };
  driver.start();
  REQUIRE(eventually([&] { return tick({1, 0, 0}), plays(-3277); }));
  device.unplug();
  REQUIRE(eventually([&] { return !tick({1, 0, 0}).drivable; }));
  device.plug_in();
  REQUIRE(eventually([&] { return tick({0.5, 0, 0}).drivable; }));
  REQUIRE(eventually([&] { return tick({2, 0, 0}), plays(-6553); }));
  device.report(1000, 0);
  REQUIRE(eventually([&] { return std::abs(tick({2, 0, 0}).position_m.x - 0.2 * 1000 / 32767) < 1e-9; }));
  CHECK(live.times_unplugged() == 1);
  CHECK(EvdevFile(device.node()).grab() == EBUSY);
  driver.stop();
  CHECK(device.told().effects.empty());
}

TEST_CASE("evdev on the kernel: the list has the device with what it can do, and other files are refused") {
  UinputDevice device;
  const std::string node = device.node();
  const auto listed = evdev_devices();
  const auto found = std::find_if(listed.begin(), listed.end(), [&](const auto& one) { return one.info.path == node; });
  REQUIRE(found != listed.end());
  CHECK(found->info.name == "evenstep uinput device");
  CHECK(found->info.vendor_id == 0x1209);
  CHECK(found->has_axis == std::array<bool, 3>{true, true, false});
  CHECK((found->constant && found->spring && found->gain && found->refusal.empty()));
  CHECK_THAT(device_error_of([] { EvdevFile file("/dev/null"); }), Contains("not an evdev device"));
  CHECK_THAT(device_error_of([] { EvdevFile file("/dev/input/event99"); }), Contains("No such file"));
}
