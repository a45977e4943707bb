#pragma once
/// The clock of a loop that blocks: a loop on a thread of its own, which asks for the time and sleeps.
///
///   void haptic_loop(evenstep::BlockingClock& clock, Device& device) {
///     for (std::int64_t k = 0;; ++k) {
///       clock.sleep_until(evenstep::tick_time({1000, 1}, k));
///       device.exchange(clock.now());
///     }
///   }
///
/// Such a loop need not become a coroutine to be tested. In the program it runs as a WallThread, or with a WallBlockingClock
/// on a thread that the program has; under test as a SteppedThread (stepped_thread.h), on the time of a scheduler.

#include <atomic>
#include <functional>
#include <memory>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/scheduler/lane.h"

namespace evenstep {

/// Thrown by sleep_until() when the run is over, so that the loop is left and its destructors run. It is not a
/// std::exception, so a loop that catches those to survive a lost device does not catch it.
struct Stopped {};

/// Only the thread that owns the clock may call it.
class BlockingClock {
 public:
  virtual ~BlockingClock() = default;

  /// The time right now. Under a virtual clock it stands still between two sleeps, however long the host takes.
  virtual RealTime now() const = 0;

  /// Returns when now() >= at. A time that has passed is allowed: a wall clock returns at once; under a scheduler everything
  /// that sorts before it at this instant runs first (lane.h). Throws Stopped if the run is over before that; but in a
  /// destructor that sleeps while an exception leaves the loop it returns at once instead.
  /// `lane` orders this wake-up among events on the same nanosecond; a wall clock ignores it. A sleep that stands for work
  /// (a render call, a step on the GPU) ends in Lane::completion.
  virtual void sleep_until(RealTime at, Lane lane) = 0;
  /// The same, in the lane of the loop.
  virtual void sleep_until(RealTime at) = 0;
};

using BlockingLoop = std::function<void(BlockingClock&)>;

/// Real time. Each thread has a clock of its own, all with the same epoch, so that their instants compare.
class WallBlockingClock final : public BlockingClock {
 public:
  /// sleep_until() throws Stopped at `end`, if it would sleep until then or longer.
  explicit WallBlockingClock(WallEpoch epoch, RealTime end = kNever) : clock_(epoch), end_(end) {}

  RealTime now() const override { return clock_.now(); }
  void sleep_until(RealTime at, Lane) override { sleep_until(at); }
  void sleep_until(RealTime at) override;

  /// Ends the sleep, and every later one, with Stopped. Callable from any thread and from a signal handler.
  void request_stop() noexcept;

 private:
  WallClock clock_;
  RealTime end_;
  std::atomic<bool> stopped_{false};
};

/// Runs a loop in real time on a thread of its own, beside all others.
class WallThread {
 public:
  WallThread(WallEpoch epoch, RealTime end, BlockingLoop loop);
  ~WallThread();  ///< request_stop(), then waits
  void request_stop() noexcept;
  /// Waits until the loop has ended; rethrows, once, the exception that left it, unless that is Stopped.
  void join();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace evenstep
