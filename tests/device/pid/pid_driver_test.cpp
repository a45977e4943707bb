#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "catch.h"
#include "pid_bench.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;
using Log = std::vector<std::string>;

namespace {

/// Largest count of the magnitude.
double counts_of(PidFlavour flavour) { return flavour == PidFlavour::mask ? 32767 : 10'000; }

/// On a device of 10 N, half a count of the magnitude is for rounding. A quarter is for a direction in 8 bits: it gives 90
/// degrees as 64 / 255 of a turn, which is 0.35 degrees off, so that 1.9e-5 of the force is lost.
double tolerance_N(PidFlavour flavour) { return 10 / counts_of(flavour) * 0.75; }

/// Such a direction also turns 0.62 % of a force along X to Y.
void require_rendered(PidBench& bench, const glm::dvec3& force_N, PidFlavour flavour) {
  const glm::dvec3 rendered = bench.device.force_N();
  const double astray_N = flavour == PidFlavour::array ? 0.0062 * std::abs(force_N.x) : 0;
  for (int axis = 0; axis < 3; ++axis)
    REQUIRE(std::abs(rendered[axis] - force_N[axis]) <= tolerance_N(flavour) + (axis == 1 ? astray_N : 0));
}

}  // namespace

TEST_CASE("start sends the mask flavour exactly these bytes and stop those") {
  PidBench bench(pid_device(PidFlavour::mask));
  bench.driver->start();
  CHECK(bench.transport.log == Log{"w 18 08", "w 18 08", "w 18 04", "w 19 FF", "w 18 01", "g 22", "s 20 01 00 00", "g 21",
                                   "w 10 01 01 F4 01 00 00 00 00 00 00 FF 00 04 28 23 00 00 00 00 00 00", "w 14 01 00 00",
                                   "w 16 01 01 01", "s 20 01 00 00", "g 21",
                                   "w 10 02 01 F4 01 00 00 00 00 00 00 FF 00 04 00 00 00 00 00 00 00 00", "w 14 02 00 00",
                                   "w 16 02 01 01"});
  CHECK((bench.device.playing() == 2 && bench.device.actuators_enabled()));
  bench.transport.log.clear();
  bench.driver->stop();
  CHECK(bench.transport.log == Log{"w 16 01 03 01", "w 16 02 03 01", "w 18 04", "w 18 02", "w 17 01", "w 17 02"});
  CHECK((bench.device.playing() == 0 && bench.device.allocated() == 0 && !bench.device.actuators_enabled()));
  bench.driver->stop();
  CHECK(bench.transport.log.size() == 6);
}

TEST_CASE("start sends the array flavour exactly these bytes and stop those") {
  PidBench bench(pid_device(PidFlavour::array));
  bench.driver->start();
  CHECK(bench.transport.log ==
        Log{"w 06 04", "w 06 04", "w 06 03", "w 07 FF", "w 06 01", "g 03", "s 01 01 00 00", "g 02",
            "w 01 01 01 F4 01 00 00 00 00 FF 00 04 40 00 00 00 00 00", "w 03 01 00 00", "w 04 01 01 01", "s 01 01 00 00",
            "g 02", "w 01 02 01 F4 01 00 00 00 00 FF 00 04 00 00 00 00 00 00", "w 03 02 00 00", "w 04 02 01 01"});
  bench.transport.log.clear();
  bench.driver->stop();
  CHECK(bench.transport.log == Log{"w 04 01 03 01", "w 04 02 03 01", "w 06 03", "w 06 02", "w 05 01", "w 05 02"});
}

TEST_CASE("a force written is the force rendered within one count for every gain and flavour") {
  std::mt19937_64 random(1);
  for (const PidFlavour flavour : kFlavours) {
    for (int percent = 1; percent <= 100; ++percent) {
      PidOptions options = pid_options();
      options.gain = percent / 100.0;
      PidBench bench(pid_device(flavour), options);
      bench.driver->start();
      const double largest_N = bench.driver->largest_force_N();
      REQUIRE(largest_N == 10 * (percent / 100.0));
      for (int i = 0; i < 100; ++i) {
        const auto draw = [&] { return (static_cast<double>(random() >> 11) / (1ll << 52) - 1) * largest_N; };
        const glm::dvec3 force{draw(), draw(), 0};
        bench.tick_at(i * kMs, force);
        require_rendered(bench, force, flavour);
      }
      REQUIRE(bench.driver->pid_counters().saturated == 0);
    }
  }
}

TEST_CASE("a force beyond the largest is cut along its axis and counted") {
  for (const PidFlavour flavour : kFlavours) {
    PidBench bench(pid_device(flavour));
    bench.driver->start();
    const double largest_N = bench.driver->largest_force_N();
    bench.tick_at(0, {100, -1, 0});
    require_rendered(bench, {largest_N, -1, 0}, flavour);
    bench.tick_at(kMs, {1, -1e12, 0});
    require_rendered(bench, {1, -largest_N, 0}, flavour);
    bench.tick_at(2 * kMs, {largest_N, -largest_N, 0});
    CHECK(bench.driver->pid_counters().saturated == 2);
  }
}

TEST_CASE("the driver keeps to its gain itself whether device and effects have gains or not") {
  for (const PidFlavour flavour : kFlavours) {
    for (const bool effect_gain : {true, false}) {
      SimulatedPidOptions device = pid_device(flavour);
      device.descriptor.device_gain = false;
      device.descriptor.effect_gain = effect_gain;
      PidBench bench(device);
      bench.driver->start();
      const double largest_N = bench.driver->largest_force_N();
      CHECK(largest_N == 2.5);
      bench.tick_at(0, {100, -100, 0});
      require_rendered(bench, {largest_N, -largest_N, 0}, flavour);
    }
  }
}

TEST_CASE("a reversed force pushes the other way and the positions stay") {
  PidOptions options = pid_options();
  options.reversed_force = {true, false, false};
  PidBench bench(pid_device(PidFlavour::mask), options, Still{{0.1, 0.05, 0}});
  bench.driver->start();
  CHECK(bench.tick_at(0, {1, 1, 0}).position_m.x == Approx(0.1).margin(1e-5));
  require_rendered(bench, {-1, 1, 0}, PidFlavour::mask);
}

TEST_CASE("one and three axes are addressed each by itself") {
  for (const PidFlavour flavour : kFlavours) {
    for (int axes = 1; axes <= 3; ++axes) {
      SimulatedPidOptions device = pid_device(flavour);
      device.descriptor.axes = axes;
      PidOptions options = pid_options();
      options.travel_m = {0.4, axes > 1 ? 0.4 : 0, axes > 2 ? 0.4 : 0};
      PidBench bench(device, options);
      bench.driver->start();
      CHECK(bench.device.playing() == axes);
      bench.tick_at(0, {1, -0.5, 0.25});
      require_rendered(bench, {1, axes > 1 ? -0.5 : 0, axes > 2 ? 0.25 : 0}, flavour);
    }
  }
}

TEST_CASE("an axis is addressed by its enable bit alone or its direction alone and not at all without both") {
  for (const PidFlavour flavour : kFlavours) {
    for (bool PidDescriptorOptions::*part : {&PidDescriptorOptions::direction, &PidDescriptorOptions::axes_enable}) {
      SimulatedPidOptions device = pid_device(flavour);
      device.descriptor.*part = false;
      PidBench bench(device);
      bench.driver->start();
      bench.tick_at(0, {1, -0.5, 0});
      require_rendered(bench, {1, -0.5, 0}, flavour);
    }
    SimulatedPidOptions neither = pid_device(flavour);
    neither.descriptor.direction = neither.descriptor.axes_enable = false;
    PidBench two(neither);
    CHECK_THROWS_WITH(two.driver->start(), Contains("no force along Y") && Contains("give it a travel of 0"));
    PidOptions options = pid_options();
    options.travel_m.y = 0;
    PidBench one(neither, options);
    one.driver->start();
    one.tick_at(0, {1, 0, 0});
    require_rendered(one, {1, 0, 0}, flavour);
  }
}

TEST_CASE("a device that leaves out any one optional part still renders the force") {
  using Options = PidDescriptorOptions;
  for (bool Options::*part : {&Options::duration, &Options::direction, &Options::axes_enable, &Options::effect_gain,
                              &Options::conditions, &Options::device_control, &Options::device_gain, &Options::block_free,
                              &Options::stop_operation, &Options::pool, &Options::state, &Options::block_load}) {
    SimulatedPidOptions device = pid_device(PidFlavour::mask);
    device.descriptor.*part = false;
    PidOptions options = pid_options();
    if (part == &Options::duration) options.effect_duration.reset();
    PidBench bench(device, options);
    bench.driver->start();
    bench.tick_at(0, {1, 0, 0});
    require_rendered(bench, {1, 0, 0}, PidFlavour::mask);
    bench.driver->stop();
    CHECK(glm::dvec3(0) == bench.device.force_N());
  }
}

TEST_CASE("arrays that count from 1 with a logical minimum of 0 are spoken to so") {
  SimulatedPidOptions device = pid_device(PidFlavour::array);
  device.descriptor.zero_is_none = true;
  PidBench bench(device);
  bench.driver->start();
  CHECK(bench.transport.log[0] == "w 06 04");
  bench.tick_at(0, {1, 0, 0});
  require_rendered(bench, {1, 0, 0}, PidFlavour::array);
}

TEST_CASE("a tick writes a report per changed axis and nothing for what is as it was") {
  PidBench bench(pid_device(PidFlavour::mask));
  bench.driver->start();
  bench.tick_at(0, {0, 0, 0});  // the first tick refreshes
  bench.transport.log.clear();
  bench.tick_at(kMs, {0, 0, 0});
  CHECK(bench.transport.log.empty());
  bench.tick_at(2 * kMs, {1, 0, 0});
  // 1 N of 10 N is 3276.7 counts of 32767. It is negative because a force to the right points against 90 degrees.
  CHECK(bench.transport.log == Log{"w 14 01 33 F3"});
  bench.tick_at(3 * kMs, {1, -1, 0});
  CHECK(bench.transport.log.back() == "w 14 02 33 F3");
  bench.tick_at(4 * kMs, {1.00001, -1.00001, 0});  // less than a count
  CHECK(bench.transport.log.size() == 2);
}

TEST_CASE("the refresh comes at half of the duration and carries force and start") {
  for (const std::int64_t duration_ms : {2, 20, 500, 4000}) {
    PidOptions options = pid_options();
    options.effect_duration = Duration{duration_ms * kMs};
    options.travel_m.y = 0;
    PidBench bench(pid_device(PidFlavour::mask), options);
    bench.driver->start();
    CHECK(bench.driver->effect_duration() == Duration{duration_ms * kMs});
    for (std::int64_t tick = 0; tick <= 5 * duration_ms; ++tick) {
      bench.transport.log.clear();
      bench.tick_at(tick * kMs, {0, 0, 0});
      REQUIRE(bench.transport.log == (tick % (duration_ms / 2) == 0 ? Log{"w 14 01 00 00", "w 16 01 01 01"} : Log{}));
      REQUIRE(bench.device.playing() == 1);
    }
    CHECK(bench.driver->pid_counters().refreshes == 11);
  }
}

TEST_CASE("a host that hangs leaves no force behind: the effect ends to the nanosecond and a write brings it back") {
  for (const PidFlavour flavour : kFlavours) {
    PidOptions options = pid_options();
    options.effect_duration = Duration{100 * kMs};
    PidBench bench(pid_device(flavour), options);
    bench.driver->start();
    for (std::int64_t tick = 0; tick < 1000; ++tick) bench.tick_at(tick * kMs, {1, 1, 0});
    require_rendered(bench, {1, 1, 0}, flavour);
    // The last refresh was at 950 ms. Reading alone does not keep effects playing.
    bench.clock.wait_until(RealTime{1050 * kMs - 1});
    bench.driver->read(bench.clock.now());
    require_rendered(bench, {1, 1, 0}, flavour);
    bench.clock.wait_until(RealTime{1050 * kMs});
    bench.driver->read(bench.clock.now());
    CHECK(bench.device.force_N() == glm::dvec3(0));
    CHECK(bench.device.playing() == 0);
    bench.tick_at(5000 * kMs, {1, 1, 0});
    require_rendered(bench, {1, 1, 0}, flavour);
  }
}

TEST_CASE("an effect without end is sent only when asked for and lasts") {
  PidOptions options = pid_options();
  options.effect_duration.reset();
  PidBench bench(pid_device(PidFlavour::mask), options);
  bench.driver->start();
  CHECK_THAT(bench.transport.log[8], Contains("w 10 01 01 FF FF "));
  CHECK_FALSE(bench.driver->effect_duration());
  bench.tick_at(0, {1, 0, 0});
  bench.clock.wait_until(RealTime{1'000'000 * kMs});
  require_rendered(bench, {1, 0, 0}, PidFlavour::mask);
  CHECK(bench.driver->pid_counters().refreshes == 1);  // in its first tick
}

TEST_CASE("a duration is cut to what the device can hold and is at least one of its counts") {
  PidOptions options = pid_options();
  options.effect_duration = Duration{3'600'000 * kMs};
  PidBench longest(pid_device(PidFlavour::array), options);
  longest.driver->start();
  CHECK(longest.driver->effect_duration() == Duration{32'767 * kMs});
  options.effect_duration = Duration{1};
  PidBench shortest(pid_device(PidFlavour::array), options);
  shortest.driver->start();
  CHECK(shortest.driver->effect_duration() == Duration{kMs});
}

TEST_CASE("without full_scale_N the driver reads positions and sends the device not one byte") {
  for (const PidFlavour flavour : kFlavours) {
    PidOptions options = pid_options();
    options.full_scale_N.reset();
    PidBench bench(pid_device(flavour), options, Still{{0.1, -0.1, 0}});
    CHECK(bench.driver->is_read_only());
    bench.driver->start();
    const DeviceSample sample = bench.driver->read(RealTime{0});
    CHECK((sample.fresh && sample.position_m.x == Approx(0.1).margin(1e-4)));
    CHECK_THROWS_WITH(bench.driver->write({0, 0, 0}),
                      Contains("no newtons") && Contains("full_scale_N") && Contains("simulated"));
    CHECK_THROWS_AS(bench.driver->write_spring({}), DeviceError);
    bench.driver->stop();
    CHECK(bench.transport.log.empty());
  }
}

TEST_CASE("a force before start or after stop is an error") {
  PidBench bench(pid_device(PidFlavour::mask));
  CHECK_THROWS_WITH(bench.driver->write({0, 0, 0}), Contains("before start()"));
  bench.driver->start();
  bench.driver->write({0, 0, 0});
  bench.driver->stop();
  CHECK_THROWS_WITH(bench.driver->write({0, 0, 0}), Contains("after stop()"));
  bench.driver->start();
  bench.tick_at(kMs, {1, 0, 0});
  require_rendered(bench, {1, 0, 0}, PidFlavour::mask);
}

TEST_CASE("positions arrive within half a count over the travel and stop at its ends") {
  for (const PidFlavour flavour : kFlavours) {
    const double half_count_m = 0.4 / (flavour == PidFlavour::mask ? 65'534 : 4095) / 2 * (1 + 1e-9);
    for (int i = -60; i <= 60; ++i) {
      const glm::dvec3 at{i * 0.005, -i * 0.0025, 0};
      PidBench bench(pid_device(flavour), pid_options(), Still{at});
      const DeviceSample sample = bench.driver->read(RealTime{7});
      REQUIRE((sample.fresh && sample.sequence == 1 && sample.read_at == RealTime{7}));
      for (int axis = 0; axis < 2; ++axis)
        REQUIRE(std::abs(sample.position_m[axis] - std::clamp(at[axis], -0.2, 0.2)) <= half_count_m);
      REQUIRE(sample.position_m.z == 0);
      REQUIRE(sample.at_range == (std::abs(i) >= 40));  // x has reached 0.2 m
    }
  }
}

namespace {

/// A device of the mask flavour whose axes may say "no value". The test chooses its input reports.
class SayingTransport final : public HidTransport {
 public:
  explicit SayingTransport(bool with_null) : descriptor_(pid_descriptor({PidFlavour::mask})) {
    const std::array<std::byte, 6> axes{std::byte{0x19}, std::byte{0x30}, std::byte{0x29},
                                        std::byte{0x31}, std::byte{0x81}, std::byte{0x02}};
    const auto at = std::search(descriptor_.begin(), descriptor_.end(), axes.begin(), axes.end());
    REQUIRE(at != descriptor_.end());
    if (with_null) *(at + 5) = std::byte{0x42};
  }
  HidRead read(std::span<std::byte> buffer) override {
    if (said.empty()) return {HidRead::Status::nothing};
    const std::vector<std::byte> report = std::exchange(said, {});
    std::copy_n(report.begin(), std::min(report.size(), buffer.size()), buffer.begin());
    return {HidRead::Status::report, report.size()};
  }
  HidWrite write(std::span<const std::byte>) override { return HidWrite::ok; }
  std::span<const std::byte> report_descriptor() const override { return descriptor_; }
  const HidDeviceInfo& info() const override { return info_; }
  void say(int x_low, int x_high) {
    said.assign({std::byte{1}, std::byte{0}, static_cast<std::byte>(x_low), static_cast<std::byte>(x_high), std::byte{0},
                 std::byte{0}});
  }
  std::vector<std::byte> said;

 private:
  std::vector<std::byte> descriptor_;
  HidDeviceInfo info_{"/dev/hidraw7", 0x1209, 0x0E58, "saying", ""};
};

}  // namespace

TEST_CASE("a position outside its range is its end or where the axis can say no value the one before") {
  for (const bool with_null : {false, true}) {
    SayingTransport transport(with_null);
    PidDriver driver(transport, layout_of(transport), pid_options());
    transport.say(0xFF, 0x3F);  // 16383
    const double before_m = driver.read(RealTime{0}).position_m.x;
    CHECK(before_m == Approx(0.1).margin(1e-5));
    transport.say(0x00, 0x80);  // -32768
    const DeviceSample sample = driver.read(RealTime{1});
    CHECK((sample.fresh && sample.position_m.x == (with_null ? before_m : -0.2)));
    transport.say(0x01, 0x80);
    CHECK(driver.read(RealTime{2}).position_m.x == -0.2);
  }
}

TEST_CASE("block load is asked until it answers as often as allowed and no more") {
  for (const PidFlavour flavour : kFlavours) {
    for (const int delay : {0, 1, 59, 60, 1000}) {
      SimulatedPidOptions device = pid_device(flavour);
      device.block_load_delay = delay;
      PidBench bench(device);
      if (delay < 60) {
        bench.driver->start();
        CHECK(bench.device.playing() == 2);
        continue;
      }
      try {
        bench.driver->start();
        FAIL("started");
      } catch (const PidBlockLoadError& error) {
        CHECK(error.reason == PidBlockLoadError::Reason::no_answer);
        CHECK_THAT(error.what(), Contains("60 tries"));
      }
      CHECK((bench.device.playing() == 0 && !bench.device.actuators_enabled()));
    }
  }
}

TEST_CASE("a full pool and a load error are errors of their own and leave nothing behind") {
  for (const PidFlavour flavour : kFlavours) {
    for (int effects = 0; effects < 2; ++effects) {
      SimulatedPidOptions full = pid_device(flavour), failing = pid_device(flavour);
      full.pool_effects = effects;
      failing.block_load_error_at = effects;
      using Reason = PidBlockLoadError::Reason;
      for (const auto& [device, reason] : {std::pair(full, Reason::full), std::pair(failing, Reason::error)}) {
        PidBench bench(device);
        try {
          bench.driver->start();
          FAIL("started");
        } catch (const PidBlockLoadError& error) {
          CHECK(error.reason == reason);
          CHECK_THAT(error.what(), Contains("simulated: the device"));
        }
        CHECK((bench.device.allocated() == 0 && bench.device.playing() == 0 && !bench.device.actuators_enabled()));
      }
    }
  }
}

TEST_CASE("a device that plays fewer effects at once than are needed is refused") {
  SimulatedPidOptions device = pid_device(PidFlavour::mask);
  device.simultaneous = 2;
  PidOptions options = pid_options();
  options.springs = true;
  options.reversed_spring[0] = false;
  PidBench bench(device, options);
  CHECK_THROWS_WITH(bench.driver->start(), Contains("plays 2 effects at once, 3 are needed"));
}

TEST_CASE("a device that does not number its blocks is given numbers from 1 on") {
  for (const PidFlavour flavour : kFlavours) {
    SimulatedPidOptions without = pid_device(flavour), unmanaged = pid_device(flavour);
    without.descriptor.block_load = false;
    unmanaged.device_managed = false;
    for (const SimulatedPidOptions& device : {without, unmanaged}) {
      PidBench bench(device);
      bench.driver->start();
      bench.tick_at(0, {1, -1, 0});
      require_rendered(bench, {1, -1, 0}, flavour);
      for (const std::string& line : bench.transport.log) CHECK(line[0] != 's');
    }
  }
}

TEST_CASE("the device is stopped when its driver ends by its scope or by an exception") {
  for (const PidFlavour flavour : kFlavours) {
    PidBench bench(pid_device(flavour));
    bench.driver->start();
    bench.tick_at(0, {1, 0, 0});
    bench.driver.reset();
    CHECK((bench.device.playing() == 0 && !bench.device.actuators_enabled() && bench.device.force_N() == glm::dvec3(0)));
    try {
      PidDriver driver(bench.transport, layout_of(bench.device), pid_options());
      driver.start();
      driver.read(RealTime{0});
      driver.write({1, 0, 0});
      CHECK(bench.device.force_N().x > 0.9);
      throw std::runtime_error("the solver diverged");
    } catch (const std::runtime_error&) {
    }
    CHECK((bench.device.playing() == 0 && !bench.device.actuators_enabled() && bench.device.force_N() == glm::dvec3(0)));
  }
}

TEST_CASE("what the device says of itself is kept and a force it does not render is counted") {
  for (const PidFlavour flavour : kFlavours) {
    SimulatedPidOptions device = pid_device(flavour);
    using Kind = PidDeviceEvent::Kind;
    device.events = {{Kind::safety_switch, RealTime{10 * kMs}, false},
                     {Kind::safety_switch, RealTime{20 * kMs}, true},
                     {Kind::actuator_power, RealTime{30 * kMs}, false},
                     {Kind::actuator_power, RealTime{40 * kMs}, true}};
    PidBench bench(device);
    CHECK_FALSE(bench.driver->state().safety_switch);
    bench.driver->start();
    for (std::int64_t tick = 0; tick < 50; ++tick) {
      bench.tick_at(tick * kMs, {1, 0, 0});
      const bool safe = tick < 10 || tick >= 20, powered = tick < 30 || tick >= 40;
      REQUIRE((bench.driver->state().safety_switch == safe && bench.driver->state().actuator_power == powered));
      REQUIRE(bench.driver->read(RealTime{tick * kMs}).drivable == (safe && powered));
      require_rendered(bench, {safe && powered ? 1 : 0, 0, 0}, flavour);
    }
    CHECK(bench.driver->pid_counters().unpowered == 20);
    CHECK(bench.driver->state().actuators_enabled == true);
    CHECK(bench.driver->state().paused == false);
    CHECK(bench.driver->state().effect_playing == true);
    // State reports come for the enabling, two starts and four events. No position report beside them is missing.
    CHECK(bench.driver->pid_counters().state_reports >= 7);
    CHECK((bench.driver->counters().reports == 50 && bench.driver->counters().malformed == 0));
  }
}

TEST_CASE("options out of range and axes that are not there are refused by name") {
  const auto refused = [](const auto& change, const char* words) {
    PidOptions options = pid_options();
    change(options);
    CHECK_THROWS_WITH(PidBench(pid_device(PidFlavour::mask), options), Contains(words));
  };
  refused([](PidOptions& o) { o.gain = 0; }, "gain is 0");
  refused([](PidOptions& o) { o.gain = 1.01; }, "gain is 1.01");
  refused([](PidOptions& o) { o.gain = std::nan(""); }, "gain");
  refused([](PidOptions& o) { o.full_scale_N = 0; }, "full_scale_N is 0");
  refused([](PidOptions& o) { o.full_scale_N = -1; }, "full_scale_N is -1");
  refused([](PidOptions& o) { o.effect_duration = Duration{0}; }, "effect_duration");
  refused([](PidOptions& o) { o.travel_m = {0, 0, 0}; }, "no axis has a travel");
  refused([](PidOptions& o) { o.travel_m.z = 0.1; }, "axis Z has a travel");
  refused([](PidOptions& o) { o.travel_m.x = -1; }, "travel_m of axis X is -1");
}

TEST_CASE("a hand on a device renders the forces written after the delay of its way") {
  SimulatedPidOptions device = pid_device(PidFlavour::mask);
  device.reports.force_delay = Duration{3 * kMs};
  HandSpec spec;
  spec.mass_kg = 0.5;
  spec.damping_N_s_per_m = 0;
  PidBench bench(device, pid_options(), Hand(spec, {Still{}, RealTime{}}));
  bench.driver->start();
  double position_m = 0;
  for (std::int64_t tick = 0; tick <= 103; ++tick) position_m = bench.tick_at(tick * kMs, {1, 0, 0}).position_m.x;
  // F t^2 / 2m over 100 ms is 10 mm. The force is 1 N up to a count of 77 uN, and a count of the position is 6 um.
  CHECK(position_m == Approx(0.01).margin(1e-5));
}
