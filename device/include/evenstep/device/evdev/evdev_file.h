#pragma once
/// A force feedback device of this machine: /dev/input/eventN of Linux. No other code opens one. What the device plays ends
/// when the file is closed, because the kernel then erases the program's effects.
///
/// Every call goes to the kernel at once and returns when the kernel's driver has it, not when the device has it: the
/// kernel's driver for PID devices queues up to 256 reports and says nothing of those that fail. On other systems the
/// constructor throws and the list is empty.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/device/evdev/evdev_node.h"

namespace evenstep {

/// What the system knows about an evdev device with force feedback without opening it.
struct EvdevListing {
  EvdevInfo info;                  ///< its name with ? for control characters
  std::array<bool, 3> has_axis{};  ///< X, Y, Z
  bool constant = false, spring = false, gain = false;
  std::string refusal;  ///< why it may not be opened ("Permission denied"); empty if it may
};

/// The devices that can play effects, in the order of their numbers.
std::vector<EvdevListing> evdev_devices();

/// All devices with the ids, serial number and name of `info`, wherever they are now, that can be opened.
std::vector<std::unique_ptr<EvdevNode>> open_again(const EvdevInfo& info);

class EvdevFile final : public EvdevNode {
 public:
  /// Throws DeviceError, with the remedy, if `path` is not an evdev device or may not be opened.
  explicit EvdevFile(const std::string& path);
  ~EvdevFile() override;
  EvdevFile(const EvdevFile&) = delete;
  EvdevFile& operator=(const EvdevFile&) = delete;

  EvdevRead read(std::span<EvdevEvent> events) override;
  /// False: the kernel has refused to stamp events by CLOCK_MONOTONIC (EVIOCSCLOCKID).
  bool tells_times() const override { return tells_times_; }
  int write(const EvdevEvent& event) override;
  int upload(EvdevEffect& effect) override;
  int erase(int id) override;
  int grab() override;
  int effect_count(int& count) override;
  bool has_axis(std::uint16_t code) override;
  bool has_feedback(std::uint16_t code) override;
  int axis(std::uint16_t code, EvdevAxis& axis) override;
  int set_axis(std::uint16_t code, const EvdevAxis& axis) override;
  const EvdevInfo& info() const override { return info_; }

 private:
  bool has(int type, std::uint16_t code);
  EvdevInfo info_;
  int fd_ = -1;
  bool tells_times_ = false;
};

}  // namespace evenstep
