#pragma once
/// The BlockingClock of the calling loop as a clock of std::chrono ([time.clock.req]), for code that takes its clock as a
/// type:
///
///   using Clock = evenstep::LoopClock;                    // was std::chrono::steady_clock
///   auto next = Clock::now();
///   for (;;) Clock::sleep_until(next += std::chrono::milliseconds(1));
///
/// std::chrono finds a clock by its type, so here, and only here, the clock is fetched and not handed in.
/// std::this_thread::sleep_until and waits of std::condition_variable would still wait in real time: call sleep_until()
/// here. Only on the thread of a SteppedThread or WallThread; elsewhere both functions throw std::logic_error.

#include <chrono>
#include <cstdint>

namespace evenstep {

struct LoopClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<LoopClock>;
  static constexpr bool is_steady = true;

  static time_point now();                 ///< ns since the start of the run
  static void sleep_until(time_point at);  ///< BlockingClock::sleep_until in the lane of the loop
};

}  // namespace evenstep
