#pragma once
/// A real HID device, through hidapi's hidraw backend. No other code uses hidapi. It works with a wall clock only, which the
/// type of the constructor's clock enforces.
///
/// hidapi 0.13.1 keeps one unguarded error string per handle and frees it twice if two threads fail on the same handle at
/// once. So every device is opened twice: one handle reads (and asks for feature reports), the other belongs to the thread
/// that writes. A write takes as long as the device needs (a USB interrupt transfer: 1 ms and more), so no caller waits for
/// it. Reports reach the device in the order of the calls; forces that a newer one has replaced are not sent (write_newest).

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/device/hid/hid_transport.h"
#include "evenstep/device/write_times.h"

namespace evenstep {

/// What the system knows about a HID device without opening it.
struct HidListing {
  HidDeviceInfo info;
  std::vector<std::byte> report_descriptor;  ///< empty if it cannot be read
  std::string refusal;                       ///< why it may not be opened ("Permission denied"); empty if it may
  std::string force_feedback_node;           ///< "/dev/input/event7" if the kernel's own driver can drive its motors too
};

/// All HID devices, each once, in the order of their paths (hidraw2 before hidraw10). Strings that a device does not have
/// are empty. Throws DeviceError if the system's list cannot be read.
std::vector<HidListing> hid_devices();
/// Whether this evenstep can open one at all (EVENSTEP_HIDAPI).
bool built_with_hidapi();

/// The line for a file in /etc/udev/rules.d (sorted before 73-seat-late.rules) that lets the person at the machine open the
/// device.
std::string udev_rule(const HidDeviceInfo& info);

class HidapiTransport final : public HidTransport {
 public:
  /// Opens /dev/hidrawN. Throws DeviceError, with the remedy, if `path` is no such device (hidapi itself would crash on some
  /// other files) or may not be opened.
  /// After the device was unplugged, it is looked for by its ids and serial number, at any path, four times a second for
  /// `patience`; meanwhile reads say `away` and writes are rejected. After that (at once if `patience` is 0) it is gone
  /// for ever.
  HidapiTransport(const std::string& path, const WallClock& clock, Duration patience = {});
  /// Goes on sending the waiting reports for at most a second, then closes. If a single write hangs, only the kernel can end
  /// it (after 5 s over USB).
  ~HidapiTransport() override;

  HidRead read(std::span<std::byte> buffer) override;
  /// Returns at once. `rejected` means that this report was dropped, because the report descriptor has no output report of
  /// its id and length or because 64 reports are waiting already. Whether the system takes it shows in refused_later(): a
  /// write that fails (stalled, timed out, would block) or takes fewer or more bytes counts; an interrupted one is repeated.
  HidWrite write(std::span<const std::byte> report) override;
  HidWrite write_newest(std::span<const std::byte> report) override;
  std::int64_t refused_later() const override;
  void wait_until_sent() override;
  HidFeature get_feature(std::span<std::byte> report) override;
  HidWrite set_feature(std::span<const std::byte> report) override;
  std::span<const std::byte> report_descriptor() const override;
  const HidDeviceInfo& info() const override;

  WriteTimes write_times() const;        ///< so far; callable from any thread
  std::int64_t times_unplugged() const;  ///< callable from any thread

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace evenstep
