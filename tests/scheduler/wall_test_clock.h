#pragma once
/// Two wall clocks: the real one, and one whose time the test sets, for tests that must be exact.

#include <memory>
#include <utility>

#include "evenstep/clock/wall_clock.h"

namespace evenstep::test {

/// Starts at t = 0.
inline std::unique_ptr<Clock> make_wall_clock() { return std::make_unique<WallClock>(WallEpoch::in({0})); }

/// A wall clock that stands still. A wait jumps to its deadline plus `lateness`, unless it was notified.
class ManualWallClock final : public Clock {
 public:
  RealTime time;
  Duration lateness{0};
  bool notified = false;

  RealTime now() const noexcept override { return time; }
  Wake wait_until(RealTime deadline) noexcept override {
    if (std::exchange(notified, false) || deadline == kNever) return Wake::notified;
    if (time < deadline) time = deadline + lateness;
    return Wake::deadline;
  }
  void notify() noexcept override { notified = true; }
  bool is_virtual() const noexcept override { return false; }
};

}  // namespace evenstep::test
