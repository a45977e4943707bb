#pragma once
/// A force feedback device that is real to Linux' input core: a program behind /dev/uinput that answers uploads and erases
/// as a driver in the kernel would, and keeps what it was told. It needs the right to open /dev/uinput.

#include <linux/uinput.h>

#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <string>
#include <thread>

class UinputDevice {
 public:
  static constexpr int kEffects = 4, kMost = 32767, kFuzz = 255;
  /// Why /dev/uinput cannot be opened; empty if it can.
  static std::string refusal();

  /// X and Y from -most to most, constant forces, springs, gain and autocenter.
  explicit UinputDevice(int most = kMost);
  ~UinputDevice();
  UinputDevice(const UinputDevice&) = delete;
  UinputDevice& operator=(const UinputDevice&) = delete;

  std::string node() const;  ///< "/dev/input/event3", as soon as the kernel has made it
  void report(int x, int y);
  void unplug();
  void plug_in();                                   ///< again after unplug(); it has forgotten everything
  void refuse(int error) { refuse_with_ = error; }  ///< uploads fail with this from now on; 0: no more

  struct Told {
    std::map<int, ff_effect> effects;  // by number
    std::map<int, int> plays;          // the last value of each
    int gain = -1, autocenter = -1;
    int uploads = 0, least_level = 0, most_level = 0;  // of effect 0
  };
  Told told() const;

 private:
  void serve();
  void answer(const input_event& event);
  int most_;
  int fd_ = -1;
  std::atomic<bool> closing_{false};
  std::atomic<int> refuse_with_{0};
  mutable std::mutex mutex_;
  Told told_;
  std::thread thread_;
};
