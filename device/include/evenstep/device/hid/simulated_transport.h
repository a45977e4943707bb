#pragma once
/// A reference device in software: makes one input report per device tick from the programmed motion, or from a hand that
/// feels the forces it was sent, and queues it as the real drivers do.
///
///   hidraw policy: 63 reports, the newest is dropped when full.   libusb policy: 32 reports, the oldest is dropped.
///   (Measured on the real ones: docs/reference-device.md.)
///
/// Tick k falls on tick_time(rate, k, first_tick) and reports the motion there, with sequence k + 1 and the tick's time in
/// whole microseconds (floored). Reads and writes look at the clock: all ticks up to clock.now() have reported. So a reader
/// that sleeps through a stall finds what a real queue would hold. A hand feels the last output report, from `force_delay` after
/// its writing on; a device that is gone pulls no more. After the unplugging every call answers `gone`, with
/// reports still queued or not, as hidapi does.

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/motion.h"

namespace evenstep {

enum class QueuePolicy { hidraw, libusb };

struct SimulatedDeviceOptions {
  Rate rate{1000, 1};
  RealTime first_tick;                   ///< time of tick 0 (the phase)
  QueuePolicy queue = QueuePolicy::hidraw;
  std::int64_t unplug_at_tick = -1;      ///< from this tick on the device is gone
  Duration force_delay;                  ///< from writing a force to when the hand feels it; a programmed motion feels none
  std::string name = "simulated";        ///< HidDeviceInfo::path: whose errors these are
};

class SimulatedTransport final : public HidTransport {
 public:
  SimulatedTransport(const Clock& clock, ProgrammedMotion motion, SimulatedDeviceOptions options);
  /// Calls may throw HandDiverged.
  SimulatedTransport(const Clock& clock, Hand hand, SimulatedDeviceOptions options);
  HidRead read(std::span<std::byte> buffer) override;
  /// `rejected`: not an output report of the reference device (a real kernel would pass on most of those).
  HidWrite write(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override;
  const HidDeviceInfo& info() const override { return info_; }

  /// The force the device would render now: the last output report; sequence 0 before the first.
  const reference_device::OutputReport& output() const { return output_; }
  /// Reports that found the queue full, or were pushed out of it, up to the last call.
  std::int64_t dropped() const { return dropped_; }

 private:
  void advance();
  glm::dvec3 position_at(std::int64_t tick);
  const Clock& clock_;
  ProgrammedMotion motion_;
  SimulatedDeviceOptions options_;
  HidDeviceInfo info_;
  std::optional<Hand> hand_;             // instead of motion_
  struct Waiting {
    std::int64_t tick;
    std::array<std::int32_t, 3> position_nm;
  };
  std::deque<Waiting> queue_;
  reference_device::OutputReport output_;
  std::int64_t next_tick_ = 0;
  std::int64_t dropped_ = 0;
  bool gone_ = false;
};

}  // namespace evenstep
