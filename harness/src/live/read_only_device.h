#pragma once
/// A device that is read but never driven, because forces are off or its full-scale force is not known.

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "evenstep/device/haptic_device.h"

namespace evenstep::internal {

class ReadOnlyDevice final : public HapticDevice {
 public:
  explicit ReadOnlyDevice(std::unique_ptr<HapticDevice> device) : device_(std::move(device)) {}
  DeviceSample read(RealTime now) override { return device_->read(now); }
  void write(const glm::dvec3&) override {}
  const DeviceCounters& counters() const override { return device_->counters(); }
  const SampleAges* ages() const override { return device_->ages(); }
  std::map<std::string, std::int64_t> own_counters() const override { return device_->own_counters(); }

 private:
  std::unique_ptr<HapticDevice> device_;
};

}  // namespace evenstep::internal
