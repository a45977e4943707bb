#pragma once
/// A reference device in software: makes one input report per device tick from the programmed motion, queues it as the
/// real drivers do, and keeps the forces it was sent.
///
///   hidraw policy: 63 reports, the newest is dropped when full.   libusb policy: 32 reports, the oldest is dropped.
///   (Measured on the real ones: docs/reference-device.md.)
///
/// Tick k falls on tick_time(rate, k, first_tick) and reports the motion there, with sequence k + 1 and the tick's time in
/// whole microseconds (floored). Reads and writes look at the clock: all ticks up to clock.now() have reported. So a reader
/// that sleeps through a stall finds what a real queue would hold. After the unplugging every call answers `gone`, with
/// reports still queued or not, as hidapi does.

#include <cstdint>
#include <deque>
#include <vector>

#include "evenstep/clock/clock.h"
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
};

class SimulatedTransport final : public HidTransport {
 public:
  SimulatedTransport(const Clock& clock, ProgrammedMotion motion, SimulatedDeviceOptions options);
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
  const Clock& clock_;
  ProgrammedMotion motion_;
  SimulatedDeviceOptions options_;
  HidDeviceInfo info_;
  std::deque<std::int64_t> queue_;       // ticks whose reports wait; the report itself is made when it is read
  reference_device::OutputReport output_;
  std::int64_t next_tick_ = 0;
  std::int64_t dropped_ = 0;
  bool gone_ = false;
};

}  // namespace evenstep
