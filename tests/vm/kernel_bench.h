#pragma once
/// What the tests on the kernel's own HID core share.

#include <chrono>
#include <thread>

#include "evenstep/clock/wall_clock.h"

inline const evenstep::WallClock& a_clock() {
  static const evenstep::WallClock clock(evenstep::WallEpoch::in(evenstep::Duration{0}));
  return clock;
}

/// A generous half minute: of real time, or of a guest's, which costs nothing while it sleeps.
template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 30'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

/// The kernel hands a report on within microseconds; nobody can see when it has.
inline void settle() { std::this_thread::sleep_for(std::chrono::milliseconds(100)); }
