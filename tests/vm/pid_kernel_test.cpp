/// The driver of force feedback devices on the kernel's own HID core and hidraw, with the firmware of the simulated device
/// behind them.

#include <array>
#include <glm/geometric.hpp>
#include <optional>

#include "catch.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/pid_driver.h"
#include "kernel_bench.h"
#include "uhid_pid_device.h"

using namespace evenstep;
using Catch::Contains;

namespace {

constexpr std::array<PidFlavour, 2> kFlavours{PidFlavour::mask, PidFlavour::array};
constexpr Duration kPatience{30'000'000'000};

SimulatedPidOptions pid_device(PidFlavour flavour) {
  SimulatedPidOptions options;
  options.descriptor.flavour = flavour;
  return options;
}

/// Two axes of 0.4 m and 10 N.
PidOptions pid_options() {
  PidOptions options;
  options.travel_m = {0.4, 0.4, 0};
  options.full_scale_N = 10;
  return options;
}

PidLayout layout_of(const HidTransport& transport) {
  return *pid_layout(*parse_report_descriptor(transport.report_descriptor()));
}

struct Bench {
  explicit Bench(const SimulatedPidOptions& options, const PidOptions& driver_options = pid_options(),
                 const Motion& motion = Still{}, Duration patience = {})
      : device(options, motion),
        transport(device.node(), a_clock(), patience),
        driver(transport, layout_of(transport), driver_options) {}

  DeviceSample read() {
    device.report();
    return driver.read(a_clock().now());
  }
  DeviceSample tick(const glm::dvec3& force_N) {
    const DeviceSample sample = read();
    driver.write(force_N);
    return sample;
  }
  /// True to within a count of the magnitude (a ten-thousandth of 10 N) and what a direction in 8 bits turns from X to Y
  /// (0.62 %).
  bool renders(const glm::dvec3& force_N) {
    return glm::length(device.look([](auto& firmware) { return firmware.force_N(); }) - force_N) <
           1e-3 + 0.0063 * std::abs(force_N.x);
  }
  int playing() {
    return device.look([](auto& firmware) { return firmware.playing(); });
  }
  /// No effect is left, and no motor is on.
  bool is_at_rest() {
    return device.look([](auto& firmware) {
      return firmware.playing() == 0 && firmware.allocated() == 0 && !firmware.actuators_enabled() &&
             firmware.force_N() == glm::dvec3(0);
    });
  }

  UhidPidDevice device;
  HidapiTransport transport;
  PidDriver driver;
};

}  // namespace

TEST_CASE("a force along each axis reaches a PID device and stop leaves nothing on it") {
  for (const PidFlavour flavour : kFlavours) {
    Bench bench(pid_device(flavour));
    bench.driver.start();
    REQUIRE(eventually([&] { return bench.playing() == 2; }));
    CHECK(bench.device.look([](auto& firmware) { return firmware.gain(); }) == 1);
    CHECK(bench.driver.largest_force_N() == 2.5);
    for (const glm::dvec3 force_N : {glm::dvec3{1.5, 0, 0}, {-1.5, 0, 0}, {0, 2, 0}, {0, -2, 0}, {0.5, -0.25, 0}}) {
      REQUIRE(eventually([&] { return bench.tick(force_N), bench.renders(force_N); }));
    }
    CHECK(bench.driver.counters().write_failures == 0);
    CHECK(bench.driver.counters().malformed == 0);
    bench.driver.stop();
    REQUIRE(eventually([&] { return bench.is_at_rest(); }));
  }
}

TEST_CASE("positions of a PID device arrive within a count of their field") {
  for (const PidFlavour flavour : kFlavours) {
    Bench bench(pid_device(flavour), pid_options(), Still{});
    REQUIRE(eventually([&] { return bench.read().fresh; }));
    CHECK(glm::length(bench.read().position_m) < 0.4 / 4095);
    // The hand moves from one end to the other in 0.8 s, and positions end there.
    Bench moving(pid_device(flavour), pid_options(), ConstantVelocity{{0.5, -0.5, 0}, Duration{0}, {-0.2, 0.2, 0}});
    double last_m = -0.2;
    REQUIRE(eventually([&] {
      const DeviceSample sample = moving.read();
      CHECK(sample.position_m.x >= last_m - 0.4 / 4095);
      CHECK(sample.position_m.y == Approx(-sample.position_m.x).margin(0.4 / 4095));
      last_m = sample.position_m.x;
      return last_m > 0.1999;
    }));
    CHECK(moving.driver.counters().malformed == 0);
  }
}

TEST_CASE("a spring on a PID device pulls to its center") {
  for (const PidFlavour flavour : kFlavours) {
    PidOptions options = pid_options();
    options.springs = true;
    options.reversed_spring = {false, false, std::nullopt};
    Bench bench(pid_device(flavour), options);
    bench.driver.start();
    REQUIRE(eventually([&] { return bench.playing() == 4; }));
    DeviceSpring spring;
    spring.center_m = {0.05, -0.02, 0};
    spring.below_N_per_m = spring.above_N_per_m = {10, 5, 0};
    spring.limit_N = {2, 2, 0};
    DeviceSpring rendered;
    REQUIRE(eventually([&] {
      bench.read();
      rendered = bench.driver.write_spring(spring);
      const glm::dvec3 force_N = bench.device.look([](auto& firmware) { return firmware.force_N(); });
      // The hand is at 0. The coefficient, the center and the saturation are each off by a count at most.
      return std::abs(force_N.x - 0.5) < 2e-3 && std::abs(force_N.y + 0.1) < 2e-3;
    }));
    CHECK(rendered.center_m.x == Approx(0.05).margin(1e-4));
    bench.driver.stop();
    REQUIRE(eventually([&] { return bench.is_at_rest(); }));
  }
}

TEST_CASE("a PID device that another program pauses says so and is driven again when it resumes") {
  for (const PidFlavour flavour : kFlavours) {
    Bench bench(pid_device(flavour));
    HidapiTransport other(bench.device.node(), a_clock());
    const PidDeviceControl control = *layout_of(other).device_control;
    const auto command = [&](const std::optional<PidChoice>& what) {
      Bytes report(control.report.size);
      report[0] = std::byte{control.report.id};
      REQUIRE(what);
      choose(report, *what);
      REQUIRE(other.write(report) == HidWrite::ok);
    };
    bench.driver.start();
    REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.renders({1, 0, 0}); }));
    for (const auto& [off, on] :
         {std::pair(control.pause, control.resume), {control.disable_actuators, control.enable_actuators}}) {
      command(off);
      REQUIRE(eventually([&] { return !bench.tick({1, 0, 0}).drivable; }));
      CHECK(bench.renders({0, 0, 0}));
      command(on);
      REQUIRE(eventually([&] { return bench.tick({1, 0, 0}).drivable; }));
      CHECK(bench.renders({1, 0, 0}));
    }
    CHECK(bench.driver.pid_counters().unpowered >= 2);
  }
}

TEST_CASE("the effects of a PID device end when the host writes no more and begin again when it does") {
  for (const PidFlavour flavour : kFlavours) {
    Bench bench(pid_device(flavour));
    bench.driver.start();
    REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.renders({1, 0, 0}); }));
    REQUIRE(eventually([&] { return bench.read(), bench.playing() == 0; }));
    CHECK(bench.renders({0, 0, 0}));
    REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.renders({1, 0, 0}); }));
  }
}

TEST_CASE("a PID device that is unplugged while it plays is an error and stop is quiet") {
  for (const PidFlavour flavour : kFlavours) {
    Bench bench(pid_device(flavour));
    bench.driver.start();
    REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.renders({1, 0, 0}); }));
    bench.device.unplug();
    const auto error = [&]() -> std::string {
      try {
        bench.driver.read(a_clock().now());
      } catch (const DeviceError& gone) {
        return gone.what();
      }
      return {};
    };
    REQUIRE(eventually([&] { return !error().empty(); }));
    CHECK_THAT(error(), Contains("device 'evenstep PID device' is gone"));
    bench.driver.stop();
  }
}

TEST_CASE("a PID device that is plugged in again is read on and never driven by the old driver") {
  for (const PidFlavour flavour : kFlavours) {
    Bench bench(pid_device(flavour), pid_options(), Still{}, kPatience);
    bench.driver.start();
    REQUIRE(eventually([&] { return bench.tick({1, 0, 0}), bench.renders({1, 0, 0}); }));
    bench.device.unplug();
    REQUIRE(eventually([&] { return bench.driver.read(a_clock().now()), bench.transport.times_unplugged() == 1; }));
    bench.device.plug_in();
    REQUIRE(eventually([&] { return !bench.tick({1, 0, 0}).drivable; }));
    REQUIRE(eventually([&] { return bench.tick({1, 0, 0}).fresh; }));
    settle();
    CHECK(bench.is_at_rest());
    bench.driver.stop();
  }
}

TEST_CASE("a full pool and a load error of a PID device are errors of their own and leave nothing behind") {
  for (const PidFlavour flavour : kFlavours) {
    SimulatedPidOptions full = pid_device(flavour), failing = pid_device(flavour);
    full.pool_effects = 1;
    failing.block_load_error_at = 1;
    failing.block_load_delay = 3;
    using Reason = PidBlockLoadError::Reason;
    for (const auto& [options, reason] : {std::pair(full, Reason::full), std::pair(failing, Reason::error)}) {
      Bench bench(options);
      std::optional<Reason> thrown;
      try {
        bench.driver.start();
      } catch (const PidBlockLoadError& error) {
        thrown = error.reason;
      }
      CHECK(thrown == reason);
      REQUIRE(eventually([&] { return bench.is_at_rest(); }));
    }
  }
}
