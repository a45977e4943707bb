#pragma once
/// The real driver of the reference device, above HidTransport: drains the queue, checks length and id, follows the
/// sequence number, converts units.
///
/// The newest report wins, by sequence number modulo 2^32; a late or repeated one changes nothing and one older than any
/// queue could hold means that the device counts anew (it was reset), which is followed without counting a loss.
/// One read handles at most 1024 reports; what is left waits for the next. Before the first report the position is 0.

#include <cstddef>
#include <cstdint>
#include <span>

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep {

class ReferenceDriver final : public HapticDevice {
 public:
  explicit ReferenceDriver(HidTransport& transport);
  DeviceSample read(RealTime now) override;
  void write(const glm::dvec3& force_N) override;
  void stop() noexcept override;  ///< sends zero force
  const DeviceCounters& counters() const override { return counters_; }

 private:
  void take(std::span<const std::byte> bytes);

  HidTransport& transport_;
  DeviceCounters counters_;
  DeviceSample last_;
  bool any_report_ = false;
  std::uint32_t output_sequence_ = 0;
};

}  // namespace evenstep
