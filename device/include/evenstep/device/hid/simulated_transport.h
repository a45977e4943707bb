#pragma once
/// A reference device in software: it makes one input report per device tick, from a programmed motion or from a hand that
/// feels the forces sent to the device, and queues it as the real drivers do.
///
/// Tick k (simulated_reports.h, which also has the queue's two policies and the faults) has sequence number k + 1 and the
/// time of the tick in whole microseconds (rounded down). Reads and writes look at the clock first: all ticks up to
/// clock.now() have then reported. So a reader that sleeps through a stall finds what a real queue would contain. A hand
/// feels the last output report from `force_delay` after it was written; a device that is gone renders no force. After the
/// device was unplugged every call returns `gone`, even if reports are still queued, as with hidapi. A device that will
/// return is `away` instead and rejects what is written; once it is back it counts reports and time anew.

#include <cstdint>

#include "evenstep/clock/clock.h"
#include "evenstep/device/hand.h"
#include "evenstep/device/hid/reference_device.h"
#include "evenstep/device/hid/simulated_motors.h"
#include "evenstep/device/hid/simulated_reports.h"
#include "evenstep/device/motion.h"

namespace evenstep {

class SimulatedTransport final : public SimulatedDevice {
 public:
  SimulatedTransport(const Clock& clock, HeldBy by, SimulatedDeviceOptions options);
  HidRead read(std::span<std::byte> buffer) override;
  /// `rejected`: it is not an output report of the reference device (a real kernel would pass most such reports on).
  HidWrite write(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override;
  const HidDeviceInfo& info() const override { return info_; }
  std::int64_t refused_later() const override { return reports_.refused_later(); }
  MotorState motors() override;

  /// The last output report, which is the force that the device would render now; before the first one its sequence is 0.
  const reference_device::OutputReport& output() const { return output_; }
  /// Reports that found the queue full, or were pushed out of it, up to the last call.
  std::int64_t dropped() const { return reports_.dropped(); }

 private:
  bool is_gone();

  const Clock& clock_;
  SimulatedReports reports_;
  HidDeviceInfo info_;
  reference_device::OutputReport output_;
  MotorLog motors_;
  std::int64_t first_tick_ = 0;  // the first since it was plugged in
  bool has_returned_ = false;    // and no read has said so
};

}  // namespace evenstep
