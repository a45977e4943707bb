#pragma once
/// A loop that blocks, run by the scheduler in virtual time: it has a thread of its own, and the scheduler steps it from one
/// sleep to the next. Of the scheduler and all stepped threads exactly one runs at any time; the others wait for their
/// turn. So shared variables need no lock, and the order is that of the scheduler: a sleep is an event, in the order
/// (time, lane, sequence) among those of coroutines and of other threads. A loop and a coroutine that ask for the same
/// events give the same trace.
///
///   Scheduler scheduler(clock, executor);
///   SteppedThread haptic(scheduler, {.name = "tick", .lane = Lane::device}, [&](BlockingClock& time) {
///     haptic_loop(time, device);
///   });
///   RunStatus status = scheduler.run(end);
///
/// With a wall clock under the scheduler the loops take turns all the same; WallThread runs them side by side.
///
/// While it runs a loop may call what a coroutine may: scheduler.now(), and scheduler.note() after its first sleep.
///
/// Errors. An exception that leaves the loop ends the run: RunEnd::failed. So does a loop that does not come back to
/// sleep_until() within `real_time_limit`: it spins, or waits for a lock, a queue or another thread, which under the
/// scheduler can move only while this one sleeps. Such a thread gets Stopped at its next sleep.
/// std::logic_error: a stepped thread that starts another, or calls run() of its own scheduler; sleep_until() from any other
/// thread than the loop's.

#include <memory>
#include <optional>

#include "evenstep/scheduler/blocking_clock.h"
#include "evenstep/scheduler/scheduler.h"

namespace evenstep {

struct SteppedThreadOptions {
  EventName name = "sleep";  ///< of its events, and of the thread in errors
  Lane lane = Lane::launch;  ///< of a sleep that names none
  /// How long one step may take in real time. Far more than any step needs, because a loaded host must not change a
  /// result. nullopt: no limit, for a debugger.
  std::optional<Duration> real_time_limit = Duration{60'000'000'000};
};

class SteppedThread {
 public:
  /// As Scheduler::spawn: the loop runs up to its first sleep at once, and that sleep is its first event. Only before run().
  SteppedThread(Scheduler& scheduler, SteppedThreadOptions options, BlockingLoop loop);
  /// Ends the loop: sleep_until() throws Stopped, and the destructors of the loop have run when this returns. What the loop
  /// throws on that way out is lost. If it does not end within `real_time_limit`, nothing can end it: a message to stderr,
  /// and std::terminate(). A scheduler that is destroyed first does the same.
  ~SteppedThread();
  SteppedThread(const SteppedThread&) = delete;
  SteppedThread& operator=(const SteppedThread&) = delete;

 private:
  struct State;
  struct EndWithLane;
  static Task lane(Scheduler& scheduler, std::shared_ptr<State> state);
  std::shared_ptr<State> state_;  // shared with the lane, which may outlive this
};

}  // namespace evenstep
