#pragma once
// A PID driver on a simulated device, with a record of every byte between them.
#include <fmt/format.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "../units.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/device/hid/pid_driver.h"
#include "evenstep/device/hid/simulated_pid_device.h"

namespace evenstep::test {

inline bool is_still(const MotorState& motors) {
  return motors.force_N == glm::dvec3(0) && motors.effects_playing == 0 && motors.effects_allocated == 0 &&
         !motors.actuators_enabled;
}

/// Passes everything on and records it: "w", "s" (set feature), "g" (get feature), with the bytes in hex.
class RecordingTransport final : public HidTransport {
 public:
  explicit RecordingTransport(HidTransport& device) : device_(device) {}
  HidRead read(std::span<std::byte> buffer) override { return device_.read(buffer); }
  HidWrite write(std::span<const std::byte> report) override { return note("w", report), device_.write(report); }
  HidFeature get_feature(std::span<std::byte> report) override {
    return note("g", report.first(1)), device_.get_feature(report);
  }
  HidWrite set_feature(std::span<const std::byte> report) override { return note("s", report), device_.set_feature(report); }
  std::span<const std::byte> report_descriptor() const override { return device_.report_descriptor(); }
  const HidDeviceInfo& info() const override { return device_.info(); }
  std::int64_t refused_later() const override { return device_.refused_later(); }

  std::vector<std::string> log;

 private:
  void note(std::string line, std::span<const std::byte> report) {
    for (const std::byte byte : report) line += fmt::format(" {:02X}", std::to_integer<int>(byte));
    log.push_back(std::move(line));
  }
  HidTransport& device_;
};

inline PidLayout layout_of(const HidTransport& device) {
  return *pid_layout(*parse_report_descriptor(device.report_descriptor()));
}

/// Two axes of 0.4 m and 10 N.
inline PidOptions pid_options() {
  PidOptions options;
  options.travel_m = {0.4, 0.4, 0};
  options.full_scale_N = 10;
  return options;
}

inline SimulatedPidOptions pid_device(PidFlavour flavour) {
  SimulatedPidOptions options;
  options.descriptor.flavour = flavour;
  return options;
}

inline constexpr std::array<PidFlavour, 2> kFlavours{PidFlavour::mask, PidFlavour::array};

struct PidBench {
  explicit PidBench(const SimulatedPidOptions& device_options, const PidOptions& driver_options = pid_options(),
                    Motion motion = Still{})
      : device(clock, ProgrammedMotion{std::move(motion), RealTime{}}, device_options), driver(make(driver_options)) {}
  PidBench(const SimulatedPidOptions& device_options, const PidOptions& driver_options, Hand hand)
      : device(clock, std::move(hand), device_options), driver(make(driver_options)) {}
  std::unique_ptr<PidDriver> make(const PidOptions& options) {
    return std::make_unique<PidDriver>(transport, layout_of(device), options);
  }
  DeviceSample tick_at(std::int64_t ns, const glm::dvec3& force_N) {
    clock.wait_until(RealTime{ns});
    const DeviceSample sample = driver->read(clock.now());
    driver->write(force_N);
    return sample;
  }

  VirtualClock clock;
  SimulatedPidDevice device;
  RecordingTransport transport{device};
  std::unique_ptr<PidDriver> driver;
};

}  // namespace evenstep::test
