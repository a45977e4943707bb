#pragma once
// What the tests of the evdev driver share, whether they use a simulated device, a scripted node or the kernel.
#include <condition_variable>
#include <cstring>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "evenstep/device/evdev/evdev_driver.h"

namespace evenstep::test {

/// Two axes of 0.4 m and 10 N, all of which may be used.
inline EvdevOptions evdev_options() {
  EvdevOptions options;
  options.travel_m = {0.4, 0.4, 0};
  options.full_scale_N = 10;
  options.gain = 1;
  return options;
}

template <class Call>
std::string device_error_of(Call call) {
  try {
    call();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return {};
}

/// A node whose answers a test chooses. Callable from any thread.
class ScriptedNode : public EvdevNode {
 public:
  EvdevRead read(std::span<EvdevEvent> into) override {
    const std::lock_guard lock(mutex);
    if (gone) return {EvdevRead::Status::gone};
    const std::size_t count = std::min(into.size(), events.size());
    std::copy_n(events.begin(), count, into.begin());
    events.erase(events.begin(), events.begin() + static_cast<std::ptrdiff_t>(count));
    return count ? EvdevRead{EvdevRead::Status::events, count} : EvdevRead{};
  }
  int write(const EvdevEvent& event) override {
    const std::lock_guard lock(mutex);
    if (!gone) written[event.code] = event.value;
    return gone ? ENODEV : 0;
  }
  int upload(EvdevEffect& effect) override {
    std::unique_lock lock(mutex);
    ++uploading;
    changed.notify_all();
    changed.wait(lock, [&] { return !is_slow; });
    if (gone || refuses_with != 0) return gone ? ENODEV : refuses_with;
    if (effect.id < 0) effect.id = static_cast<std::int16_t>(first_id + static_cast<int>(effects.size()));
    effects[effect.id] = effect;
    uploads.push_back(effect);
    return 0;
  }
  int erase(int id) override {
    const std::lock_guard lock(mutex);
    return gone ? ENODEV : effects.erase(id) == 1 ? 0 : EINVAL;
  }
  int grab() override { return is_held ? EBUSY : 0; }
  int effect_count(int&) override { return 0; }
  bool has_axis(std::uint16_t code) override { return code < 2; }
  bool has_feedback(std::uint16_t) override { return true; }
  int axis(std::uint16_t code, EvdevAxis& axis) override {
    const std::lock_guard lock(mutex);
    if (gone) return ENODEV;
    axis = {code == 0 ? x : 0, -100, 100};
    return 0;
  }
  int set_axis(std::uint16_t, const EvdevAxis&) override { return 0; }
  const EvdevInfo& info() const override { return here; }

  /// Changes something while no call is being answered.
  template <class Change>
  void change(Change change) {
    const std::lock_guard lock(mutex);
    change();
    changed.notify_all();
  }
  /// Looks at something while no call is being answered, and returns what was seen.
  template <class Look>
  auto look(Look look) {
    const std::lock_guard lock(mutex);
    return look();
  }
  void wait_for_upload(int number) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return uploading >= number; });
  }

  std::vector<EvdevEvent> events;
  std::int32_t x = 0;
  bool is_slow = false, is_held = false, gone = false;
  int refuses_with = 0, first_id = 0;
  int uploading = 0;  // number of upload calls, including those that wait
  std::map<int, EvdevEffect> effects;
  std::map<int, int> written;
  std::vector<EvdevEffect> uploads;
  EvdevInfo here{"/dev/input/event7", "a node", 1, 2, ""};

 private:
  std::mutex mutex;
  std::condition_variable changed;
};

}  // namespace evenstep::test
