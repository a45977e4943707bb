#pragma once
/// The two ways to a force feedback board on USB: directly through hidraw, with our own PID driver, and through evdev, with
/// the kernel's PID driver (hid-pidff).

#include <chrono>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <thread>

#include "evenstep/device/evdev/evdev_driver.h"
#include "evenstep/device/evdev/evdev_file.h"
#include "evenstep/device/evdev/live_evdev.h"
#include "evenstep/device/hid/hidapi_transport.h"
#include "evenstep/device/hid/pid_driver.h"
#include "evenstep/device/hid/simulated_board.h"
#include "kernel_bench.h"
#include "usbip_pid_device.h"

constexpr double kFull_N = 10;
constexpr double kFullSlope_N_per_m = 50;

inline evenstep::SimulatedBoardOptions firmware(evenstep::BoardKind kind) {
  evenstep::SimulatedBoardOptions options;
  options.kind = kind;
  options.travel_m = {0.4, 0.4, 0};
  options.full_scale_N = kFull_N;
  options.full_slope_N_per_m = glm::dvec3(kFullSlope_N_per_m);
  options.firmware_rate = {1000, 1};
  return options;
}

/// The options for both drivers. `springs`: a user has measured that positive coefficients pull towards the center.
template <class Options>
Options told(evenstep::BoardKind kind, bool springs = false) {
  const bool has_y = evenstep::motors_of(kind) > 1;
  Options options;
  options.travel_m = {0.4, has_y ? 0.4 : 0, 0};
  options.full_scale_N = kFull_N;
  options.full_slope_N_per_m = glm::dvec3(kFullSlope_N_per_m);
  options.gain = 1;
  options.reversed_force[0] = options.reversed_force[1] = kind == evenstep::BoardKind::arduino;
  options.springs = springs;
  if (springs) options.reversed_spring[0] = false;
  if (springs && has_y) options.reversed_spring[1] = false;
  return options;
}

struct Direct {
  Direct(const UsbipPidDevice& device, evenstep::PidOptions options) : transport(device.hidraw_node(), a_clock()) {
    driver = std::make_unique<evenstep::PidDriver>(
        transport, *evenstep::pid_layout(*evenstep::parse_report_descriptor(transport.report_descriptor())), options);
  }
  evenstep::HidapiTransport transport;
  std::unique_ptr<evenstep::HapticDevice> driver;
};

/// Through the kernel's driver, as in live runs.
struct ByKernel {
  ByKernel(const UsbipPidDevice& device, const evenstep::EvdevOptions& options)
      : node(
            std::make_unique<evenstep::EvdevFile>(device.event_node()), [] { return evenstep::EvdevNodes(); }, a_clock()),
        driver(std::make_unique<evenstep::EvdevDriver>(node, options)) {}
  evenstep::LiveEvdev node;
  std::unique_ptr<evenstep::HapticDevice> driver;
};

inline void pause(std::int64_t us) { std::this_thread::sleep_for(std::chrono::microseconds(us)); }

/// What the device renders 12 ticks after such a command.
inline glm::dvec3 rendered(const UsbipPidDevice& device, evenstep::HapticDevice& driver, const glm::dvec3& force_N,
                           const std::optional<evenstep::DeviceSpring>& spring = {}) {
  for (int tick = 0; tick < 12; ++tick) {
    driver.read(a_clock().now());
    if (spring) driver.write_spring(*spring);
    driver.write(force_N);
    pause(1000);
  }
  return device.force_N();
}

/// Along X, along Y, along both; the last but one is small, and the last is none.
constexpr glm::dvec3 kForces_N[] = {{1, 0, 0},  {-1, 0, 0}, {0, 2, 0},    {0, -2, 0},
                                    {5, -3, 0}, {-9, 9, 0}, {0.05, 0, 0}, {0, 0, 0}};
