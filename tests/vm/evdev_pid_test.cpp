/// A simulated force feedback board on USB, driven by the kernel's own PID driver (hid-pidff) and by ours: what is sent when
/// it is plugged in, and how long forces and positions take. Forces of all boards: board_kernel_test.cpp.

#include <algorithm>
#include <array>
#include <cstdio>
#include <glm/geometric.hpp>
#include <iterator>
#include <string>
#include <vector>

#include "catch.h"
#include "two_ways.h"

using namespace evenstep;

namespace {

constexpr std::uint8_t kControl = 0x0C;  // OpenFFBoard's report Device Control

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
  // Linux 6.1 writes the number of a command, 4 for Device Reset, into the one bit of the first command. There it is cut
  // off, and nothing is reset.
  CHECK(device.outputs(kControl) == std::vector<std::vector<std::uint8_t>>{{kControl, 0}, {kControl, 0}, {kControl, 1}});
  std::array<std::vector<glm::dvec3>, 2> forces_N;
  std::array<Latency, 2> latencies;
  const auto drive = [&](auto&& way, std::size_t place) {
    way.driver->start();
    for (const glm::dvec3& force_N : kForces_N) forces_N[place].push_back(rendered(device, *way.driver, force_N));
    latencies[place] = latency(device, *way.driver);
    way.driver->stop();
    pause(50'000);
    CHECK(device.force_N() == glm::dvec3(0));
  };
  drive(ByKernel(device, told<EvdevOptions>(kind)), 1);
  drive(Direct(device, told<PidOptions>(kind)), 0);
  say("direct", latencies[0]);
  say("evdev", latencies[1]);
  for (std::size_t i = 0; i < forces_N[0].size(); ++i) {
    std::printf("force %zu: direct %.4f %.4f, evdev %.4f %.4f N\n", i, forces_N[0][i].x, forces_N[0][i].y, forces_N[1][i].x,
                forces_N[1][i].y);
    CHECK(glm::length(forces_N[0][i] - forces_N[1][i]) < 2e-4 * kFull_N);
  }
  std::fflush(stdout);
}
