#include "evenstep/device/evdev/evdev_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/input.h>
#include <linux/major.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "evdev_listing.h"
#include "evenstep/device/haptic_device.h"

namespace evenstep {
namespace fs = std::filesystem;
namespace {

static_assert(evdev::kConstant == FF_CONSTANT && evdev::kSpring == FF_SPRING && evdev::kGain == FF_GAIN &&
              evdev::kAutocenter == FF_AUTOCENTER && evdev::kAbs == EV_ABS && evdev::kFf == EV_FF &&
              evdev::kSynDropped == SYN_DROPPED);

const fs::path kClass = "/sys/class/input";

/// The time of an event, ns; kNever for a time that no clock can show.
RealTime time_of(const input_event& event) {
  constexpr std::uint64_t kMost_s = 9'000'000'000;
  const auto s = static_cast<std::uint64_t>(event.input_event_sec), us = static_cast<std::uint64_t>(event.input_event_usec);
  if (s > kMost_s || us >= 1'000'000) return kNever;
  return RealTime{static_cast<std::int64_t>(s * 1'000'000'000 + us * 1000)};
}

/// Returns 0 or the errno.
template <class Argument>
int ask(int fd, unsigned long request, Argument argument) {
  return ::ioctl(fd, request, argument) < 0 ? errno : 0;
}

std::string line_of(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  return line;
}

internal::EvdevTexts texts_of(const std::string& event) {
  const fs::path device = kClass / event / "device";
  return {line_of(device / "name"),           line_of(device / "id/vendor"),       line_of(device / "id/product"),
          line_of(device / "uniq"),           line_of(device / "capabilities/ff"), line_of(device / "capabilities/abs"),
          line_of(device / "capabilities/ev")};
}

ff_effect kernel_effect(const EvdevEffect& effect) {
  ff_effect out{};
  out.type = effect.type;
  out.id = effect.id;
  out.direction = effect.direction;
  out.replay.length = effect.length_ms;
  if (effect.type == FF_CONSTANT) out.u.constant.level = effect.level;
  for (std::size_t axis = 0; axis < 2 && effect.type == FF_SPRING; ++axis) {
    const EvdevCondition& from = effect.conditions[axis];
    out.u.condition[axis] = {from.right_saturation, from.left_saturation, from.right_coefficient,
                             from.left_coefficient, from.dead_band,       from.center};
  }
  return out;
}

}  // namespace

std::vector<EvdevListing> evdev_devices() {
  std::vector<std::pair<long, EvdevListing>> found;
  std::error_code gone;  // a device may be unplugged meanwhile; the result is then whatever is still there
  for (fs::directory_iterator at(kClass, gone), end; !gone && at != end; at.increment(gone)) {
    const std::string event = at->path().filename().string();
    if (event.compare(0, 5, "event") != 0) continue;
    const internal::EvdevTexts texts = texts_of(event);
    if (!internal::has_effects(texts)) continue;
    EvdevListing listing = internal::evdev_listing(texts);
    listing.info.path = "/dev/input/" + event;
    if (::access(listing.info.path.c_str(), R_OK | W_OK) != 0) listing.refusal = std::strerror(errno);
    found.emplace_back(std::strtol(event.c_str() + 5, nullptr, 10), std::move(listing));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<EvdevListing> listings;
  for (auto& [number, listing] : found) listings.push_back(std::move(listing));
  return listings;
}

std::vector<std::unique_ptr<EvdevNode>> open_again(const EvdevInfo& info) {
  std::vector<std::unique_ptr<EvdevNode>> opened;
  for (const EvdevListing& one : evdev_devices()) {
    const EvdevInfo& found = one.info;
    if (found.vendor_id != info.vendor_id || found.product_id != info.product_id || found.serial != info.serial ||
        found.name != info.name)
      continue;
    try {
      opened.push_back(std::make_unique<EvdevFile>(found.path));
    } catch (const DeviceError&) {  // not ready yet: udev sets its permissions a moment after it appears
    }
  }
  return opened;
}

EvdevFile::EvdevFile(const std::string& path) {
  struct stat node {};
  if (::stat(path.c_str(), &node) != 0) throw DeviceError(fmt::format("{}: {}", path, std::strerror(errno)));
  std::error_code missing;
  const std::string event = fs::canonical(path, missing).filename().string();
  if (!S_ISCHR(node.st_mode) || major(node.st_rdev) != INPUT_MAJOR || event.compare(0, 5, "event") != 0)
    throw DeviceError(path +
                      ": not an evdev device (/dev/input/event*); `evenstep devices` lists those with force feedback");
  fd_ = ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd_ < 0) {
    throw DeviceError(
        fmt::format("{}: {}; a line in /etc/udev/rules.d/70-evenstep.rules lets the person at the machine open "
                    "it: KERNEL==\"event*\", SUBSYSTEM==\"input\", TAG+=\"uaccess\"",
                    path, std::strerror(errno)));
  }
  info_ = internal::evdev_listing(texts_of(event)).info;
  info_.path = path;
  const int monotonic = CLOCK_MONOTONIC;
  tells_times_ = ask(fd_, EVIOCSCLOCKID, &monotonic) == 0;
}

EvdevFile::~EvdevFile() { ::close(fd_); }

EvdevRead EvdevFile::read(std::span<EvdevEvent> events) {
  std::array<input_event, 64> got;
  const ssize_t size = ::read(fd_, got.data(), std::min(events.size(), got.size()) * sizeof(input_event));
  if (size < 0) {
    if (errno == EAGAIN) return {EvdevRead::Status::nothing};
    return {errno == EINTR ? EvdevRead::Status::interrupted : EvdevRead::Status::gone};
  }
  const std::size_t count = static_cast<std::size_t>(size) / sizeof(input_event);
  for (std::size_t i = 0; i < count; ++i) events[i] = {got[i].type, got[i].code, got[i].value, time_of(got[i])};
  return {count > 0 ? EvdevRead::Status::events : EvdevRead::Status::nothing, count};
}

int EvdevFile::write(const EvdevEvent& event) {
  input_event out{};
  out.type = event.type;
  out.code = event.code;
  out.value = event.value;
  return ::write(fd_, &out, sizeof out) < 0 ? errno : 0;
}

int EvdevFile::upload(EvdevEffect& effect) {
  ff_effect out = kernel_effect(effect);
  const int error = ask(fd_, EVIOCSFF, &out);
  if (error == 0) effect.id = out.id;
  return error;
}

int EvdevFile::erase(int id) { return ask(fd_, EVIOCRMFF, id); }
int EvdevFile::grab() { return ask(fd_, EVIOCGRAB, 1); }
int EvdevFile::effect_count(int& count) { return ask(fd_, EVIOCGEFFECTS, &count); }

bool EvdevFile::has(int type, std::uint16_t code) {
  std::array<std::uint8_t, std::max(ABS_CNT, FF_CNT) / 8> bits{};
  const unsigned long request = _IOC(_IOC_READ, 'E', 0x20 + type, bits.size());  // EVIOCGBIT
  return code / 8u < bits.size() && ask(fd_, request, bits.data()) == 0 && (bits[code / 8u] >> (code % 8u) & 1) != 0;
}
bool EvdevFile::has_axis(std::uint16_t code) { return has(EV_ABS, code); }
/// The bits of effects alone say nothing: see has_effects (evdev_listing.h).
bool EvdevFile::has_feedback(std::uint16_t code) { return has(0, EV_FF) && has(EV_FF, code); }

int EvdevFile::axis(std::uint16_t code, EvdevAxis& axis) {
  input_absinfo got{};
  const int error = ask(fd_, EVIOCGABS(code), &got);
  if (error == 0) axis = {got.value, got.minimum, got.maximum, got.fuzz, got.flat, got.resolution};
  return error;
}

int EvdevFile::set_axis(std::uint16_t code, const EvdevAxis& axis) {
  const input_absinfo wanted{axis.value, axis.minimum, axis.maximum, axis.fuzz, axis.flat, axis.resolution};
  return ask(fd_, EVIOCSABS(code), &wanted);
}

}  // namespace evenstep
