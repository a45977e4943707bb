#pragma once
/// A reference device in software: makes one input report per device tick from the programmed motion, or from a hand that
/// feels the forces it was sent, and queues it as the real drivers do.
///
/// Tick k (simulated_reports.h, with the queue's two policies and what can go wrong) has sequence k + 1 and the tick's time
/// in whole microseconds (floored). Reads and writes look at the clock: all ticks up to clock.now() have reported. So a
/// reader that sleeps through a stall finds what a real queue would hold. A hand feels the last output report, from
/// `force_delay` after its writing on; a device that is gone pulls no more. After the unplugging every call answers `gone`,
/// with reports still queued or not, as hidapi does.

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
  SimulatedTransport(const Clock& clock, ProgrammedMotion motion, SimulatedDeviceOptions options);
  /// Calls may throw HandDiverged.
  SimulatedTransport(const Clock& clock, Hand hand, SimulatedDeviceOptions options);
  HidRead read(std::span<std::byte> buffer) override;
  /// `rejected`: not an output report of the reference device (a real kernel would pass on most of those).
  HidWrite write(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override;
  const HidDeviceInfo& info() const override { return info_; }
  MotorState motors() override;

  /// The force the device would render now: the last output report; sequence 0 before the first.
  const reference_device::OutputReport& output() const { return output_; }
  /// Reports that found the queue full, or were pushed out of it, up to the last call.
  std::int64_t dropped() const { return reports_.dropped(); }

 private:
  SimulatedTransport(const Clock& clock, SimulatedReports reports);
  const Clock& clock_;
  SimulatedReports reports_;
  HidDeviceInfo info_;
  reference_device::OutputReport output_;
  MotorLog motors_;
};

}  // namespace evenstep
