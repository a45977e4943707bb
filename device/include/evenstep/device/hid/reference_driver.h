#pragma once
/// The real driver of the reference device, above HidTransport: it drains the queue, checks length and id, follows the
/// sequence number and converts units.
///
/// The newest report counts, by sequence number modulo 2^32. A late or repeated report changes nothing. A report that is
/// older than any queue could hold means that the device has been reset and counts anew; the driver then follows the new
/// count and counts no loss. One read handles at most 1024 reports; the rest wait for the next read. Before the first report
/// the position is 0.
///
/// If a clock is followed, `taken_at` is that of the newest report, even in a sample that is not fresh.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "evenstep/device/device_clock.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep {

class ReferenceDriver final : public HapticDevice {
 public:
  /// With a clock, a sample says when it was taken; without one, the reports' time stamps are not used.
  explicit ReferenceDriver(HidTransport& transport, std::optional<DeviceClock> clock = std::nullopt);
  DeviceSample read(RealTime now) override;
  void write(const glm::dvec3& force_N) override;
  void stop() noexcept override;            ///< sends zero force
  double largest_force_N() const override;  ///< 2147 N
  const DeviceCounters& counters() const override { return counters_; }
  const SampleAges* ages() const override { return clock_ ? &clock_->ages() : nullptr; }

 private:
  void take(std::span<const std::byte> bytes);
  void begin_anew();

  HidTransport& transport_;
  std::optional<DeviceClock> clock_;
  DeviceCounters counters_;
  DeviceSample last_;
  bool any_report_ = false;
  std::uint32_t output_sequence_ = 0;
  std::int64_t refusals_seen_ = 0;
};

}  // namespace evenstep
