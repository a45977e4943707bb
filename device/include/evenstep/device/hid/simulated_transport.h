#pragma once
/// A reference device in software: makes one input report per device tick from the programmed motion, queues it as the
/// real drivers do, and keeps the forces it was sent.
///
///   hidraw policy: 63 reports, the newest is dropped when full.   libusb policy: 32 reports, the oldest is dropped.
///   (Measured on the real ones: docs/reference-device.md.)
///
/// Reads look at the clock: all ticks up to clock.now() have reported. So a reader that sleeps through a stall finds what a
/// real queue would hold.

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
  RealTime first_tick;                   ///< phase
  QueuePolicy queue = QueuePolicy::hidraw;
  std::int64_t unplug_at_tick = -1;      ///< from this tick on the device is gone
};

class SimulatedTransport final : public HidTransport {
 public:
  SimulatedTransport(const Clock& clock, ProgrammedMotion motion, SimulatedDeviceOptions options);
  HidRead read(std::span<std::byte> buffer) override;
  HidWrite write(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override;
  const HidDeviceInfo& info() const override { return info_; }

  /// The force the device would render now (last output report), uN.
  const reference_device::OutputReport& output() const { return output_; }
  std::int64_t dropped() const { return dropped_; }

 private:
  void advance();
  const Clock& clock_;
  ProgrammedMotion motion_;
  SimulatedDeviceOptions options_;
  HidDeviceInfo info_;
  std::deque<reference_device::InputReport> queue_;
  reference_device::OutputReport output_;
  std::int64_t next_tick_ = 0;
  std::int64_t dropped_ = 0;
  bool gone_ = false;
};

}  // namespace evenstep
