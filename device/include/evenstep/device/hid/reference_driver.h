#pragma once
/// The real driver of the reference device, above HidTransport: drains the queue, checks length and id, follows the
/// sequence number, converts units.

#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/hid_transport.h"

namespace evenstep {

class ReferenceDriver final : public HapticDevice {
 public:
  explicit ReferenceDriver(HidTransport& transport);
  DeviceSample read(RealTime now) override;
  void write(const glm::dvec3& force_N) override;
  const DeviceCounters& counters() const override { return counters_; }

 private:
  HidTransport& transport_;
  DeviceCounters counters_;
  DeviceSample last_;
  bool any_report_ = false;
  std::uint32_t output_sequence_ = 0;
};

}  // namespace evenstep
