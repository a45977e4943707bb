#pragma once
/// What the two kinds of thread that run a BlockingLoop have in common.

#include <exception>

#include "evenstep/scheduler/blocking_clock.h"

namespace evenstep::internal {

/// The clock of the loop that runs on this thread; null on any other thread.
inline thread_local BlockingClock* clock_of_this_thread = nullptr;

/// Runs the loop on this thread until it ends or is stopped.
inline void run_until_stopped(const BlockingLoop& loop, BlockingClock& clock) {
  clock_of_this_thread = &clock;
  try {
    loop(clock);
  } catch (const Stopped&) {
  }
}

/// What a sleep does when the run is over.
inline void leave_loop() {
  if (std::uncaught_exceptions() == 0) throw Stopped{};  // thrown during unwinding, it would end the program
}

}  // namespace evenstep::internal
