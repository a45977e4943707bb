#pragma once
/// The simulated force feedback device (simulated_pid_device.h) on the kernel's own HID core: the same firmware, but on the
/// machine's clock instead of a virtual one. It needs the right to open /dev/uhid.

#include <optional>
#include <string>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/simulated_pid_device.h"
#include "uhid_device.h"

class UhidPidDevice {
 public:
  explicit UhidPidDevice(const evenstep::SimulatedPidOptions& options, const evenstep::Motion& motion = evenstep::Still{});

  /// Passes to the kernel everything that the firmware has to report by now: positions that are due, changes of its state.
  void report();
  /// The result of `look`, which is called with the firmware between two of its reports.
  template <class Look>
  auto look(Look look) {
    return device_->with_firmware([&] { return look(*firmware_); });
  }
  std::string node() const { return device_->node(); }
  void unplug() { device_->unplug(); }
  void plug_in();  ///< plugs it in again after unplug(); without power it has forgotten everything

 private:
  evenstep::SimulatedPidOptions options_;
  evenstep::Motion motion_;
  evenstep::WallClock clock_;
  std::optional<evenstep::SimulatedPidDevice> firmware_;
  std::optional<UhidDevice> device_;  // the last member, because its thread calls the firmware
};
