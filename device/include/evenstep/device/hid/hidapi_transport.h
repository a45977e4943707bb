#pragma once
/// A real HID device through hidapi's hidraw backend: the only place that hidapi is seen. For a wall clock only; the type of the
/// constructor's clock says so.
///
/// hidapi 0.13.1 keeps one unguarded error string per handle and frees it twice when two threads fail on one handle at once, so
/// every device is opened twice: one handle reads (and asks for feature reports), the other belongs to the thread that writes.
/// A write takes as long as the device likes (a USB interrupt transfer: 1 ms and more), so no caller waits for it.
/// Reports reach the device in the order of the calls; forces that a newer one overtook are left out (write_newest).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/time/duration_histogram.h"

namespace evenstep {

/// What the system knows of one HID device without opening it.
struct HidListing {
  HidDeviceInfo info;
  std::vector<std::byte> report_descriptor;  ///< empty where it cannot be read
  std::string refusal;                       ///< empty: it may be opened; else why not ("Permission denied")
  std::string force_feedback_node;           ///< "/dev/input/event7": the kernel's own driver can drive its motors, too
};

/// All HID devices, each once, in the order of their paths (hidraw2 before hidraw10). Strings that the device does not have are
/// empty. Throws DeviceError where the system's list cannot be read.
std::vector<HidListing> hid_devices();

/// The line for a file below /etc/udev/rules.d (sorting before 73-seat-late.rules) that lets the person at the machine open it.
std::string udev_rule(const HidDeviceInfo& info);

/// What became of the reports that were to be sent.
struct HidWriteTimes {
  DurationHistogram taken;         ///< by one write, until the system had the report
  std::int64_t overtaken = 0;      ///< forces that a newer one replaced before they were sent
  std::int64_t rejected = 0;       ///< by the system, or by a full queue
};

class HidapiTransport final : public HidTransport {
 public:
  /// Opens /dev/hidrawN. Throws DeviceError, with the remedy, where `path` is no such device (hidapi itself would crash on some
  /// other file), or may not be opened.
  /// For `patience` after it was unplugged, the same device (ids and serial) is looked for four times a second, at whatever path;
  /// meanwhile reads find nothing and writes are rejected. Then, or with no patience at once, it is gone for ever.
  HidapiTransport(const std::string& path, const WallClock& clock, Duration patience = {});
  /// Sends what still waits for at most a second, then closes. A single write that hangs is the kernel's to end (5 s over USB).
  ~HidapiTransport() override;

  HidRead read(std::span<std::byte> buffer) override;
  /// Returns at once: the answer is about the reports before. `rejected`: one of them was since the last call; or the report
  /// descriptor has no output report of this id and length, or 64 reports wait already, and this one was dropped.
  HidWrite write(std::span<const std::byte> report) override;
  HidWrite write_newest(std::span<const std::byte> report) override;
  HidFeature get_feature(std::span<std::byte> report) override;
  HidWrite set_feature(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override;
  const HidDeviceInfo& info() const override;

  HidWriteTimes write_times() const;  ///< so far; any thread
  std::int64_t times_unplugged() const;  ///< any thread

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace evenstep
