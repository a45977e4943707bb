// Any bytes as what Linux says about an event device. Up to the first zero byte they are the texts of sysfs, one per line.
// After it come the axes, the capabilities and the events.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <sstream>

#include "evdev/evdev_listing.h"
#include "evenstep/device/evdev/evdev_driver.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// Gives the bytes one after another, and zeros after the last.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : at_(data), left_(size) {}
  template <class Value>
  Value next() {
    Value value{};
    const std::size_t size = std::min(left_, sizeof value);
    if (size > 0) std::memcpy(&value, at_, size);
    at_ += size;
    left_ -= size;
    return value;
  }
  bool is_empty() const { return left_ == 0; }

 private:
  const std::uint8_t* at_;
  std::size_t left_;
};

/// Whatever the driver asks, the next bytes are the answer.
class FuzzedNode final : public EvdevNode {
 public:
  FuzzedNode(Bytes bytes, bool timed) : bytes_(bytes), timed_(timed), can_(bytes_.next<std::uint8_t>()) {
    for (EvdevAxis& axis : axes_) axis = bytes_.next<EvdevAxis>();
  }
  EvdevRead read(std::span<EvdevEvent> events) override {
    constexpr EvdevRead::Status kOthers[] = {EvdevRead::Status::nothing, EvdevRead::Status::interrupted,
                                             EvdevRead::Status::away, EvdevRead::Status::returned, EvdevRead::Status::gone};
    const auto what = bytes_.next<std::uint8_t>();
    if (what < std::size(kOthers)) return {kOthers[what]};
    EvdevRead got{EvdevRead::Status::events, std::min<std::size_t>(what % 64u, events.size())};
    for (std::size_t i = 0; i < got.count; ++i) {
      events[i].type = bytes_.next<std::uint8_t>();
      events[i].code = bytes_.next<std::uint8_t>();
      events[i].value = bytes_.next<std::int32_t>();
      if (timed_) events[i].at = RealTime{bytes_.next<std::int64_t>()};
    }
    return got;
  }
  int write(const EvdevEvent& event) override {
    require(event.type == evdev::kFf, "something else than force feedback is written");
    return answer();
  }
  int upload(EvdevEffect& effect) override {
    require(effect.length_ms > 0, "an effect without an end");
    const int error = answer();
    if (error == 0 && effect.id < 0) effect.id = static_cast<std::int16_t>(bytes_.next<std::uint8_t>());
    return error;
  }
  Upload uploaded(int) override { return static_cast<Upload>(bytes_.next<std::uint8_t>() % 3); }
  int erase(int) override { return answer(); }
  int grab() override { return answer(); }
  int effect_count(int& count) override { return count = bytes_.next<int>(), answer(); }
  bool has_axis(std::uint16_t code) override { return (can_ >> code & 1) != 0; }
  bool has_feedback(std::uint16_t code) override { return (can_ >> (3 + code % 4) & 1) != 0; }
  int axis(std::uint16_t code, EvdevAxis& axis) override {
    axis = axes_[code];
    if ((can_ & 0x80) != 0) axis.value = bytes_.next<std::int32_t>();
    return answer();
  }
  int set_axis(std::uint16_t, const EvdevAxis& axis) override {
    require(axis.minimum <= axis.maximum, "a range that was turned round");
    return answer();
  }
  const EvdevInfo& info() const override { return info_; }
  bool is_empty() const { return bytes_.is_empty(); }

 private:
  int answer() {
    constexpr int kErrors[] = {ENODEV, ENXIO, EAGAIN, EINTR, ENOSPC, EINVAL, EACCES, EIO, EBUSY, ENOSYS};
    const auto what = bytes_.next<std::uint8_t>();
    return what >= 1 && what <= std::size(kErrors) ? kErrors[what - 1] : 0;
  }
  Bytes bytes_;
  bool timed_;  // its events have times
  std::uint8_t can_;
  std::array<EvdevAxis, 3> axes_;
  EvdevInfo info_{"/dev/input/event0", "fuzzed", 0, 0, ""};
};

void require_sound(const DeviceSample& sample, const EvdevOptions& options, RealTime& last_taken) {
  const RealTime taken = sample.taken_at.value_or(last_taken);
  require(sample.taken_at.has_value() == options.unchanged_age.has_value(), "a time that was not asked for, or none");
  require(taken >= last_taken && taken <= sample.read_at, "a time that goes back, or is in the future");
  require(!sample.fresh || !sample.taken_at || taken >= sample.read_at - Duration{1'000'000'000},
          "a new sample of long ago");
  last_taken = taken;
  for (int axis = 0; axis < 3; ++axis) {
    require(std::abs(sample.position_m[axis]) <= options.travel_m[axis] / 2, "a position outside its travel");
  }
}

void list(const std::string& text) {
  std::istringstream lines(text);
  internal::EvdevTexts texts;
  for (std::string* line :
       {&texts.name, &texts.vendor, &texts.product, &texts.serial, &texts.effects, &texts.axes, &texts.types})
    std::getline(lines, *line);
  const EvdevListing listing = internal::evdev_listing(texts);
  for (const char c : listing.info.name + listing.info.serial)
    require(static_cast<unsigned char>(c) >= 0x20 && c != 0x7F, "a name that controls a terminal");
  require(internal::has_effects(texts) || !(listing.constant || listing.spring || listing.gain), "an effect of nothing");
}

void drive(Bytes bytes) {
  EvdevOptions options;
  options.travel_m = {0.4, 0.2, 0.1};
  options.full_scale_N = 10;
  options.gain = 1;
  const auto ways = bytes.next<std::uint8_t>();
  options.springs = ways % 2 == 0;
  const bool timed = ways >= 0x80;
  if (timed) options.unchanged_age = Duration{2'000'000};
  options.reversed_spring[1] = true;
  FuzzedNode node(bytes, timed);
  for (int axis = 0; axis < 3; ++axis) {
    if (!node.has_axis(static_cast<std::uint16_t>(axis))) options.travel_m[axis] = 0;
  }
  try {
    EvdevDriver driver(node, options);
    driver.start();
    RealTime now, last_taken{-10'000'000'000};
    while (!node.is_empty()) {
      now = now + Duration{1'000'000};
      require_sound(driver.read(now), options, last_taken);
      driver.write({1e-3 * static_cast<double>(now.ns % 7), -2, 0});
      if (options.springs) driver.write_spring({{0.05, 0, 0}, glm::dvec3(3), glm::dvec3(5), glm::dvec3(1)});
    }
    require(driver.counters().reports >= 0 && driver.counters().write_failures >= 0, "a count below zero");
  } catch (const DeviceError& error) {
    require(error.what() != std::string("/dev/input/event0: "), "an error without words");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::uint8_t* const text_end = std::find(data, data + size, std::uint8_t{0});
  list(std::string(data, text_end));
  if (text_end != data + size) drive(Bytes(text_end + 1, static_cast<std::size_t>(data + size - text_end) - 1));
  return 0;
}
