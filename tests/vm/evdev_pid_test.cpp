/// Simulated force feedback boards on USB, as the kernel's own PID driver (hid-pidff) sees them: driven through evdev and
/// directly through hidraw. Our reading of the PID standard and that of the kernel must make the same forces from the same
/// commands.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "catch.h"
#include "evenstep/device/evdev/evdev_driver.h"
#include "evenstep/device/evdev/evdev_file.h"
#include "evenstep/device/evdev/live_evdev.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/pid_driver.h"
#include "evenstep/device/hid/simulated_board.h"
#include "kernel_bench.h"
#include "usbip_pid_device.h"

using namespace evenstep;

namespace {

constexpr double kFull_N = 10;
constexpr std::uint8_t kControl = 0x0C;  // OpenFFBoard's report Device Control

SimulatedBoardOptions firmware(BoardKind kind) {
  SimulatedBoardOptions options;
  options.kind = kind;
  options.travel_m = {0.4, 0.4, 0};
  options.full_scale_N = kFull_N;
  options.firmware_rate = {1000, 1};
  return options;
}

/// The options for both drivers.
template <class Options>
Options told(BoardKind kind) {
  Options options;
  options.travel_m = {0.4, 0.4, 0};
  options.full_scale_N = kFull_N;
  options.gain = 1;
  options.reversed_force[0] = options.reversed_force[1] = kind == BoardKind::arduino;
  return options;
}

struct Direct {
  Direct(const UsbipPidDevice& device, BoardKind kind) : transport(device.hidraw_node(), a_clock()) {
    driver = std::make_unique<PidDriver>(transport, *pid_layout(*parse_report_descriptor(transport.report_descriptor())),
                                         told<PidOptions>(kind));
  }
  HidapiTransport transport;
  std::unique_ptr<HapticDevice> driver;
};

/// Through the kernel's driver, as in live runs.
struct ByKernel {
  ByKernel(const UsbipPidDevice& device, BoardKind kind)
      : node(
            std::make_unique<EvdevFile>(device.event_node()), [] { return EvdevNodes(); }, a_clock()),
        driver(std::make_unique<EvdevDriver>(node, told<EvdevOptions>(kind))) {}
  LiveEvdev node;
  std::unique_ptr<HapticDevice> driver;
};

void pause(std::int64_t us) { std::this_thread::sleep_for(std::chrono::microseconds(us)); }

/// What the device renders 12 ticks after each command.
std::vector<glm::dvec3> rendered(const UsbipPidDevice& device, HapticDevice& driver) {
  std::vector<glm::dvec3> forces_N;
  const auto run = [&](const glm::dvec3& force_N) {
    for (int tick = 0; tick < 12; ++tick) {
      driver.read(a_clock().now());
      driver.write(force_N);
      pause(1000);
    }
    forces_N.push_back(device.force_N());
  };
  for (const glm::dvec3 force_N :
       {glm::dvec3{1, 0, 0}, {-1, 0, 0}, {0, 2, 0}, {0, -2, 0}, {5, -3, 0}, {-9, 9, 0}, {0.05, 0, 0}, {0, 0, 0}})
    run(force_N);
  return forces_N;
}

struct Latency {
  std::vector<double> force_ms, position_ms;
  static double quantile(std::vector<double> values, double share) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
  }
};

/// The latency from write() until the device renders another force, and from a report of the device until read() has it.
Latency latency(const UsbipPidDevice& device, HapticDevice& driver) {
  Latency found;
  for (int change = 0; change < 100; ++change) {
    pause(3000 + 137 * (change % 7));
    driver.read(a_clock().now());
    const RealTime asked = a_clock().now();
    driver.write({change % 2 ? 3.0 : -3.0, 0, 0});
    for (int waited = 0; device.force_changed_at() < asked && waited < 4000; ++waited) {
      pause(50);
    }
    found.force_ms.push_back(seconds(device.force_changed_at() - asked) * 1e3);
  }
  std::uint32_t before = driver.read(a_clock().now()).sequence;
  for (int tick = 0; tick < 800; ++tick) {
    pause(50);
    const DeviceSample sample = driver.read(a_clock().now());
    if (sample.sequence != before) found.position_ms.push_back(seconds(sample.read_at - device.reported_at()) * 1e3);
    before = sample.sequence;
  }
  return found;
}

bool plays_constant_forces(const UsbipPidDevice& device) {
  const auto all = evdev_devices();
  const std::string node = device.event_node();
  return std::any_of(all.begin(), all.end(), [&](const auto& one) { return one.info.path == node && one.constant; });
}

void say(const char* way, const Latency& found) {
  std::printf("latency %s: force p50 %.3f p99 %.3f max %.3f ms, position p50 %.3f p99 %.3f ms of %zu\n", way,
              Latency::quantile(found.force_ms, 0.5), Latency::quantile(found.force_ms, 0.99),
              Latency::quantile(found.force_ms, 1), Latency::quantile(found.position_ms, 0.5),
              Latency::quantile(found.position_ms, 0.99), found.position_ms.size());
}

}  // namespace

TEST_CASE("usbip: the kernel's PID driver and ours make the same forces of the same commands") {
  if (const std::string refusal = UsbipPidDevice::refusal(); !refusal.empty()) {
    WARN("no USB/IP here: " << refusal);
    return;
  }
  const BoardKind kind = BoardKind::openffboard_2;
  // At 10 mm/s the position changes with every report.
  UsbipPidDevice device(a_clock(), firmware(kind), ConstantVelocity{{0.01, 0.01, 0}});
  REQUIRE(!device.hidraw_node().empty());
  REQUIRE(plays_constant_forces(device));
  // Linux 6.1 writes the number of a command, 4 for Device Reset, into the one bit of the first command. There it is cut
  // off, and nothing is reset.
  CHECK(device.outputs(kControl) == std::vector<std::vector<std::uint8_t>>{{kControl, 0}, {kControl, 0}, {kControl, 1}});
  std::array<std::vector<glm::dvec3>, 2> forces_N;
  std::array<Latency, 2> latencies;
  const auto drive = [&](auto&& way, std::size_t place) {
    way.driver->start();
    forces_N[place] = rendered(device, *way.driver);
    latencies[place] = latency(device, *way.driver);
    way.driver->stop();
    pause(50'000);
    CHECK(device.force_N() == glm::dvec3(0));
  };
  drive(ByKernel(device, kind), 1);
  drive(Direct(device, kind), 0);
  say("direct", latencies[0]);
  say("evdev", latencies[1]);
  for (std::size_t i = 0; i < forces_N[0].size(); ++i) {
    std::printf("force %zu: direct %.4f %.4f, evdev %.4f %.4f N\n", i, forces_N[0][i].x, forces_N[0][i].y, forces_N[1][i].x,
                forces_N[1][i].y);
    CHECK(glm::length(forces_N[0][i] - forces_N[1][i]) < 2e-4 * kFull_N);
  }
  std::fflush(stdout);
}

TEST_CASE("usbip: the kernel's PID driver plays no forces on a board without Start Delay or Set Envelope") {
  if (const std::string refusal = UsbipPidDevice::refusal(); !refusal.empty()) {
    WARN("no USB/IP here: " << refusal);
    return;
  }
  UsbipPidDevice device(a_clock(), firmware(BoardKind::arduino));
  REQUIRE(!device.hidraw_node().empty());
  CHECK_FALSE(plays_constant_forces(device));
}
