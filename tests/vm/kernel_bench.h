#pragma once
/// What the tests on the kernel's own HID core share.

#include <chrono>
#include <thread>

#include "evenstep/clock/wall_clock.h"

inline const evenstep::WallClock& a_clock() {
  static const evenstep::WallClock clock(evenstep::WallEpoch::in(evenstep::Duration{0}));
  return clock;
}

/// Waits for a condition for at most half a minute, which is generous. In a virtual machine sleeping takes no real time.
template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 30'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// The kernel passes a report on within microseconds, but a test cannot see when it has.
inline void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(100)); }
