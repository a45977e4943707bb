#pragma once
/// A HID device that the kernel itself believes in: a program behind /dev/uhid. Everything above it is real: the kernel's HID
/// core, hidraw with its queue, sysfs, and libhidapi. Needs the right to open /dev/uhid.

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
    /// What the device does: takes its output reports, takes and answers its feature reports. Without one they are kept, and
    /// answered as told by answer_feature. Called under the device's mutex (with_firmware); it must outlive the device.
    evenstep::HidTransport* firmware = nullptr;
  };
  /// Empty if /dev/uhid can be opened, else why not.
  static std::string refusal();

  /// Throws std::runtime_error where the kernel does not take it.
  explicit UhidDevice(Spec spec);
  ~UhidDevice();
  UhidDevice(const UhidDevice&) = delete;
  UhidDevice& operator=(const UhidDevice&) = delete;

  void send(std::span<const std::byte> report);
  void unplug();
  void plug_in();  ///< again, after unplug()
  void answer_feature(Bytes report);  ///< of id report[0]; others are refused

  /// While nothing reaches the firmware.
  template <class Use>
  auto with_firmware(Use use) const {
    const std::lock_guard lock(mutex_);
    return use();
  }

  std::vector<Bytes> outputs() const;
  std::vector<Bytes> features_set() const;

  /// "/dev/hidraw3", once the kernel has made it and udev, where there is one, has seen it; empty after a generous wait: the
  /// kernel refused the descriptor.
  std::string node() const;
  /// "0003:1209:0E57.0004": its name below /sys/bus/hid/devices; empty as above.
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
  mutable std::mutex mutex_;  // all below
  std::vector<Bytes> outputs_, features_set_, feature_answers_;
};
