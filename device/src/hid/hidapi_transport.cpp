#include "evenstep/device/hid/hidapi_transport.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <optional>
#include <utility>

#include "../live_sender.h"
#include "../printable.h"
#include "evenstep/device/haptic_device.h"
#include "evenstep/device/hid/report_descriptor.h"
#include "hidapi_library.h"
#include "hidraw_sysfs.h"

namespace evenstep {
namespace {

using internal::hidapi;
using internal::printable;

/// The largest report that hidraw delivers (HID_MAX_BUFFER_SIZE is larger).
constexpr std::size_t kLargestReport = 4096;
/// How long wait_until_sent() waits: stop() calls it for each of its ten or so reports, and a write takes 1 to 8 ms.
constexpr std::chrono::milliseconds kSettles{250};
/// How long a feature report waits for queued writes. The kernel ends a write over USB after 5 s, and they go one by one.
constexpr std::chrono::seconds kFeatureWaits{60};

/// hidapi's list of devices, opening a device and its global error string share unguarded state.
std::mutex& hidapi_mutex() {
  static std::mutex mutex;
  return mutex;
}

/// hidapi's strings are wide and may be missing; characters outside ASCII would need a locale, which is not set here.
std::string text_of(const wchar_t* wide) {
  std::string text;
  for (; wide && *wide; ++wide) text += *wide < 0x80 ? static_cast<char>(*wide) : '?';
  return text;
}

struct CloseHid {
  void operator()(hid_device* device) const { hidapi().hid_close(device); }
};
using HidHandle = std::unique_ptr<hid_device, CloseHid>;

std::string or_else(std::string text, const std::string& name, const char* key) {
  return text.empty() ? internal::hidraw_property(name, key) : text;
}

std::string refusal_of(const std::string& path) {
  return access(path.c_str(), R_OK | W_OK) == 0 ? "" : std::strerror(errno);
}

HidListing listing_of(const hid_device_info& entry) {
  HidListing listing;
  const std::string name = internal::hidraw_name(entry.path);
  listing.info = {entry.path, entry.vendor_id, entry.product_id,
                  printable(or_else(text_of(entry.product_string), name, "HID_NAME")),
                  printable(or_else(text_of(entry.serial_number), name, "HID_UNIQ"))};
  listing.report_descriptor = internal::hidraw_report_descriptor(name);
  listing.refusal = refusal_of(entry.path);
  listing.force_feedback_node = internal::hidraw_force_feedback_node(name);
  return listing;
}

/// Orders hidraw2 before hidraw10.
bool by_path(const HidListing& a, const HidListing& b) {
  return std::pair(a.info.path.size(), a.info.path) < std::pair(b.info.path.size(), b.info.path);
}

/// The two handles of a device (hidapi_transport.h explains why there are two).
struct Handles {
  HidHandle reader, writer;
};

Handles open_handles(const HidDeviceInfo& info) {
  const std::lock_guard lock(hidapi_mutex());
  Handles handles{HidHandle(hidapi().hid_open_path(info.path.c_str())), nullptr};
  if (handles.reader) handles.writer.reset(hidapi().hid_open_path(info.path.c_str()));
  if (handles.writer) return handles;
  throw DeviceError(
      fmt::format("{}: cannot be opened: {}; if permission is missing, paste this line into "
                  "/etc/udev/rules.d/70-evenstep.rules and plug the device in again: {}",
                  info.path, text_of(hidapi().hid_error(nullptr)), udev_rule(info)));
}

bool is_same_device(const HidDeviceInfo& a, const HidDeviceInfo& b) {
  return a.vendor_id == b.vendor_id && a.product_id == b.product_id && a.serial == b.serial;
}

struct OneReport {
  std::array<std::byte, kLargestReport> bytes;
  std::size_t size = 0;
  bool newest = false;
};

/// A hint for a path that this driver cannot open but another can.
std::string for_another_driver(std::string_view path) {
  if (path.starts_with("ws://")) return "; a [[device]] takes the address of a service with driver = \"inverse3\"";
  if (path.starts_with("/dev/input/event")) return "; a [[device]] takes an event node with driver = \"evdev\"";
  return {};
}

}  // namespace

bool built_with_hidapi() { return true; }

std::vector<HidListing> hid_devices() {
  const std::lock_guard lock(hidapi_mutex());
  if (hidapi().hid_init() != 0) throw DeviceError("hidapi cannot be started: " + text_of(hidapi().hid_error(nullptr)));
  std::vector<HidListing> found;
  hid_device_info* const all = hidapi().hid_enumerate(0, 0);
  for (const hid_device_info* entry = all; entry; entry = entry->next) {
    // hidapi has one entry per usage, so a force-feedback device has dozens of entries with the same path.
    const auto same_path = [&](const HidListing& listing) { return listing.info.path == entry->path; };
    if (std::none_of(found.begin(), found.end(), same_path)) found.push_back(listing_of(*entry));
  }
  hidapi().hid_free_enumeration(all);
  std::sort(found.begin(), found.end(), by_path);
  return found;
}

std::string udev_rule(const HidDeviceInfo& info) {
  return fmt::format(R"(KERNEL=="hidraw*", KERNELS=="*:{:04X}:{:04X}.*", TAG+="uaccess")", info.vendor_id, info.product_id);
}

struct HidapiTransport::State final : internal::LiveSender<OneReport, HidHandle>::Cable {
  State(const std::string& path, const WallClock& clock, Duration patience) {
    const std::string name = internal::hidraw_name(path);
    if (name.empty() && for_another_driver(path).empty() && path.starts_with('/') && ::access(path.c_str(), F_OK) != 0)
      throw DeviceError(path + ": no such file; `evenstep devices` lists the devices that are there");
    if (name.empty())
      throw DeviceError(path + ": not a hidraw device; `evenstep devices` lists those that are there" +
                        for_another_driver(path));
    for (HidListing& device : hid_devices()) {
      if (internal::hidraw_name(device.info.path) == name) listing = std::move(device);
    }
    if (listing.info.path.empty())
      throw DeviceError(path + ": the system does not list it; `evenstep devices` lists what is there");
    auto parsed = parse_report_descriptor(listing.report_descriptor);
    if (!parsed) {
      throw DeviceError(fmt::format("{}: byte {} of its report descriptor: {}; without it no report can be sent safely",
                                    path, parsed.error().offset, parsed.error().message));
    }
    descriptor = *std::move(parsed);
    Handles handles = open_handles(listing.info);
    reader = std::move(handles.reader);
    writer = std::move(handles.writer);
    sender.emplace(clock, patience, *this);
  }

  bool is_declared(ReportType type, std::span<const std::byte> report) const;
  HidWrite put(std::span<const std::byte> report, bool newest);
  HidWrite send(const OneReport& report) override;
  std::optional<HidHandle> find() override;

  HidListing listing;
  ReportDescriptor descriptor;
  HidHandle reader;  // for the thread that reads
  HidHandle writer;  // for the thread that writes
  std::array<std::byte, kLargestReport> input;
  std::optional<internal::LiveSender<OneReport, HidHandle>> sender;  // the last member, because it uses all others
};

/// Whether the descriptor declares such a report: the kernel would send one of any id and length, and return success.
bool HidapiTransport::State::is_declared(ReportType type, std::span<const std::byte> report) const {
  const HidReport* const declared =
      report.empty() ? nullptr : descriptor.report(type, std::to_integer<std::uint8_t>(report[0]));
  return declared && declared->size() == report.size() && report.size() <= kLargestReport;
}

HidWrite HidapiTransport::State::put(std::span<const std::byte> report, bool newest) {
  if (!is_declared(ReportType::output, report)) return sender->reject();
  const auto same = [&](const OneReport& other) {
    const std::size_t key = std::min<std::size_t>(2, std::min(other.size, report.size()));
    return std::equal(report.begin(), report.begin() + static_cast<std::ptrdiff_t>(key), other.bytes.begin());
  };
  return sender->put(newest, same, [&](OneReport& slot) {
    std::copy(report.begin(), report.end(), slot.bytes.begin());
    slot.size = report.size();
  });
}

HidWrite HidapiTransport::State::send(const OneReport& report) {
  const auto* const bytes = reinterpret_cast<const unsigned char*>(report.bytes.data());
  int written;
  do {
    errno = 0;
    written = hidapi().hid_write(writer.get(), bytes, report.size);
  } while (written < 0 && errno == EINTR);
  if (written == static_cast<int>(report.size)) return HidWrite::ok;
  return written < 0 && (errno == ENODEV || errno == EIO || errno == ESHUTDOWN) ? HidWrite::gone : HidWrite::rejected;
}

std::optional<HidHandle> HidapiTransport::State::find() {
  try {
    for (const HidListing& device : hid_devices()) {
      if (!is_same_device(device.info, listing.info)) continue;
      Handles found = open_handles(device.info);
      writer = std::move(found.writer);
      return std::move(found.reader);
    }
  } catch (const DeviceError&) {  // not ready yet: udev sets its permissions a moment after it appears
  }
  return std::nullopt;
}

HidapiTransport::HidapiTransport(const std::string& path, const WallClock& clock, Duration patience)
    : state_(std::make_unique<State>(path, clock, patience)) {}

HidapiTransport::~HidapiTransport() {
  state_->sender.reset();
  const std::lock_guard lock(hidapi_mutex());
  state_.reset();
}

HidRead HidapiTransport::read(std::span<std::byte> buffer) {
  const auto without_device = [](internal::Presence presence) {
    return HidRead{presence == internal::Presence::gone ? HidRead::Status::gone : HidRead::Status::away};
  };
  if (const internal::Presence presence = state_->sender->presence(); presence != internal::Presence::here)
    return without_device(presence);
  if (auto returned = state_->sender->take_returned()) {
    state_->reader = *std::move(returned);
    return {HidRead::Status::returned};
  }
  auto* const input = reinterpret_cast<unsigned char*>(state_->input.data());
  errno = 0;
  // The buffer has the largest size there is, because the kernel cuts a longer report silently.
  const int size = hidapi().hid_read_timeout(state_->reader.get(), input, state_->input.size(), 0);
  if (size == 0) return {HidRead::Status::nothing};
  if (size < 0 && errno == EINTR) return {HidRead::Status::interrupted};
  if (size < 0) return without_device(state_->sender->lose());
  const auto bytes = static_cast<std::size_t>(size);
  std::copy_n(state_->input.begin(), std::min(bytes, buffer.size()), buffer.begin());
  return {HidRead::Status::report, bytes};
}

HidWrite HidapiTransport::write(std::span<const std::byte> report) { return state_->put(report, false); }
HidWrite HidapiTransport::write_newest(std::span<const std::byte> report) { return state_->put(report, true); }

/// Feature reports take another way to the device than the waiting output reports, but must not overtake them: a Device
/// Reset that is sent late would remove the effect that a later Create New Effect has made.
HidFeature HidapiTransport::get_feature(std::span<std::byte> report) {
  state_->sender->wait_until_sent(kFeatureWaits);
  errno = 0;
  auto* const bytes = reinterpret_cast<unsigned char*>(report.data());
  const int size = hidapi().hid_get_feature_report(state_->reader.get(), bytes, report.size());
  if (size >= 0) return {HidFeature::Status::ok, static_cast<std::size_t>(size)};
  if (errno == EINTR) return {HidFeature::Status::interrupted};
  return {errno == ENODEV ? HidFeature::Status::gone : HidFeature::Status::rejected};
}

HidWrite HidapiTransport::set_feature(std::span<const std::byte> report) {
  if (!state_->is_declared(ReportType::feature, report)) return HidWrite::rejected;
  state_->sender->wait_until_sent(kFeatureWaits);
  const auto* const bytes = reinterpret_cast<const unsigned char*>(report.data());
  int size;
  do {
    errno = 0;
    size = hidapi().hid_send_feature_report(state_->reader.get(), bytes, report.size());
  } while (size < 0 && errno == EINTR);
  if (size >= 0) return HidWrite::ok;
  return errno == ENODEV ? HidWrite::gone : HidWrite::rejected;
}

std::int64_t HidapiTransport::refused_later() const { return state_->sender->refused(); }
void HidapiTransport::wait_until_sent() { state_->sender->wait_until_sent(kSettles); }
std::span<const std::byte> HidapiTransport::report_descriptor() const { return state_->listing.report_descriptor; }
const HidDeviceInfo& HidapiTransport::info() const { return state_->listing.info; }

std::int64_t HidapiTransport::times_unplugged() const { return state_->sender->times_unplugged(); }
WriteTimes HidapiTransport::write_times() const { return state_->sender->times(); }

}  // namespace evenstep
