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

  /// The time right now, read anew at each call. Callable from any thread; never runs backwards.
  virtual RealTime now() const noexcept = 0;

  /// Returns Wake::deadline when now() >= deadline, or Wake::notified when notify() was called since the last return
  /// (even before this call: a notification is never lost). A pending notification takes precedence over a deadline that
  /// has been reached; several pending notifications count as one. What was written before notify() is visible after
  /// Wake::notified. Call it from the owner's thread only.
  /// A deadline in the past returns at once. kNever means no deadline: a wall clock then waits for a notification; a
  /// virtual clock with none pending would deadlock, so it returns Wake::notified and its owner can find out why.
  virtual Wake wait_until(RealTime deadline) noexcept = 0;

  /// Ends a wait early. Callable from any thread and from a signal handler.
  virtual void notify() noexcept = 0;

  /// True if waiting costs no real time and the speed of the host must not influence what happens.
  virtual bool is_virtual() const noexcept = 0;
};

}  // namespace evenstep
