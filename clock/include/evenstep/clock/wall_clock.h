#pragma once
/// A clock that counts CLOCK_MONOTONIC from an epoch. It waits on a futex with an absolute time-out (a finished GPU kernel
/// could not wake clock_nanosleep) and spins for the last part of the wait, still watching for notifications.
/// docs/numerics.md has the measurements behind this.
///
/// Lanes on several threads use one WallClock each, made with the same epoch, so that their instants compare.

#include <atomic>
#include <string>

#include "evenstep/clock/clock.h"

namespace evenstep {

/// The CLOCK_MONOTONIC reading, in ns, at which a run's RealTime{0} lies.
struct WallEpoch {
  std::int64_t monotonic_ns = 0;
  static WallEpoch in(Duration from_now);  ///< an epoch a little in the future, so that lanes can be ready for t = 0
};

class WallClock final : public Clock {
 public:
  explicit WallClock(WallEpoch epoch, Duration spin_tail = {60'000});

  RealTime now() const noexcept override;
  Wake wait_until(RealTime deadline) noexcept override;
  void notify() noexcept override;
  bool is_virtual() const noexcept override { return false; }

 private:
  WallEpoch epoch_;
  Duration spin_tail_;
  std::atomic<std::uint32_t> notified_{0};  // the futex word
};

/// What the operating system has granted the calling thread.
struct RealTimeGrant {
  bool fifo = false;           ///< SCHED_FIFO at the priority asked for
  bool memory_locked = false;  ///< mlockall(MCL_CURRENT)
  std::string refusal;         ///< empty, or why something was refused (errno text): the run is marked "not real-time"
};
/// Sets the calling thread's timer slack to 1 ns (always), and SCHED_FIFO and mlockall where permitted.
RealTimeGrant request_real_time(int fifo_priority);
/// Gives the calling thread the ordinary priority, which it may not have from the thread that started it.
void leave_real_time();

/// CPU time that this process has used, s, all threads together: for run-time reports, never for decisions.
double process_cpu_seconds();
/// CLOCK_MONOTONIC, s since an arbitrary origin: for run-time reports, never for decisions.
double monotonic_seconds();
/// CLOCK_REALTIME, whole s since 1970-01-01 UTC: the date of a report, never for decisions.
std::int64_t unix_seconds();

}  // namespace evenstep
