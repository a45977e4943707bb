#include "uhid_pid_device.h"

#include <array>

using namespace evenstep;

namespace {

UhidDevice::Spec spec_of(SimulatedPidDevice& firmware) {
  UhidDevice::Spec spec;
  spec.vendor = firmware.info().vendor_id;
  spec.product = firmware.info().product_id;
  spec.name = firmware.info().product;
  spec.report_descriptor.assign(firmware.report_descriptor().begin(), firmware.report_descriptor().end());
  spec.firmware = &firmware;
  return spec;
}

}  // namespace

UhidPidDevice::UhidPidDevice(const SimulatedPidOptions& options, const Motion& motion)
    : options_(options), motion_(motion), clock_(WallEpoch::in(Duration{0})) {
  firmware_.emplace(clock_, ProgrammedMotion{motion_, RealTime{}}, options_);
  device_.emplace(spec_of(*firmware_));
}

void UhidPidDevice::report() {
  std::array<std::byte, 64> buffer;
  device_->with_firmware([&] {
    HidRead got;
    while ((got = firmware_->read(buffer)).status == HidRead::Status::report)
      device_->send(std::span<const std::byte>(buffer).first(got.size));
  });
}

void UhidPidDevice::plug_in() {
  firmware_.emplace(clock_, ProgrammedMotion{motion_, RealTime{}}, options_);
  device_->plug_in();
}
