#pragma once
/// A HID device that is real to the kernel: a program behind /dev/uhid. Everything above it is real: the kernel's HID core,
/// hidraw with its queue, sysfs, and libhidapi. It needs the right to open /dev/uhid.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "evenstep/device/hid/hid_transport.h"

using Bytes = std::vector<std::byte>;

class UhidDevice {
 public:
  struct Spec {
    std::uint32_t vendor = 0x1209, product = 0x0E57;
    std::string name = "evenstep reference device", serial = "SN0001";
    Bytes report_descriptor;
    /// The firmware receives the output reports, and receives and answers the feature reports. Without it they are kept, and
    /// answered as answer_feature says. It is called under the device's mutex (with_firmware) and must outlive the device.
    evenstep::HidTransport* firmware = nullptr;
  };
  /// Why /dev/uhid cannot be opened; empty if it can.
  static std::string refusal();

  /// Throws std::runtime_error if the kernel does not accept it.
  explicit UhidDevice(Spec spec);
  ~UhidDevice();
  UhidDevice(const UhidDevice&) = delete;
  UhidDevice& operator=(const UhidDevice&) = delete;

  void send(std::span<const std::byte> report);
  void unplug();
  void plug_in();                     ///< plugs it in again after unplug()
  void answer_feature(Bytes report);  ///< sets the feature report of id report[0]; others are refused

  /// Calls `use` while nothing can reach the firmware.
  template <class Use>
  auto with_firmware(Use use) const {
    const std::lock_guard lock(mutex_);
    return use();
  }

  std::vector<Bytes> outputs() const;
  std::vector<Bytes> features_set() const;

  /// "/dev/hidraw3", as soon as the kernel has made it and udev, if it runs, has seen it. Empty after a generous wait, which
  /// means that the kernel has refused the descriptor.
  std::string node() const;
  /// "0003:1209:0E57.0004", its name in /sys/bus/hid/devices; empty as above.
  std::string hid_name() const;

 private:
  void create();
  void destroy();
  void serve();
  void take(const Bytes& output);
  bool take_feature(const Bytes& report);
  Bytes feature(std::uint8_t id);

  Spec spec_;
  std::string unique_;  // HID_PHYS, by which the device is found in sysfs
  int fd_ = -1;
  std::atomic<bool> closing_{false};
  std::thread thread_;
  mutable std::mutex mutex_;  // guards everything below
  std::vector<Bytes> outputs_, features_set_, feature_answers_;
};
