#pragma once
/// The seam between evenstep and the passage of real time: everything that must know or wait for real time is handed a
/// Clock by reference. There is no global clock; only this room asks the operating system.
///
///   VirtualClock  jumps to the next deadline: programmed timing, deterministic, faster than real time.
///   WallClock     CLOCK_MONOTONIC with an interruptible absolute wait.
///
/// One conformance test body runs on both (tests/clock/conformance_test.cpp).

#include "evenstep/time/time.h"

namespace evenstep {

enum class Wake { deadline, notified };

class Clock {
 public:
  virtual ~Clock() = default;

  /// A live read. Any thread. Never runs backwards.
  virtual RealTime now() const noexcept = 0;

  /// Returns Wake::deadline when now() >= deadline, or Wake::notified when notify() was called since the last return
  /// (also before the call: a notification is never lost). A pending notification goes before a reached deadline; several
  /// pending ones are one. What was written before notify() is visible after Wake::notified. Owner's thread only.
  /// A deadline in the past returns at once. kNever is no deadline: a wall clock waits for a notification; a virtual
  /// clock without one would be in a deadlock, and returns Wake::notified so that its owner can look why.
  virtual Wake wait_until(RealTime deadline) noexcept = 0;

  /// Ends a wait early. Any thread, also from a signal handler.
  virtual void notify() noexcept = 0;

  /// True where waiting costs nothing and the host's speed must not be visible.
  virtual bool is_virtual() const noexcept = 0;
};

}  // namespace evenstep
