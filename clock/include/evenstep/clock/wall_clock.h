#pragma once
/// CLOCK_MONOTONIC since an epoch, waiting by futex with an absolute time-out (clock_nanosleep cannot be woken by a
/// finished kernel) and a short spin tail that also watches for notifications. Measured reasons: docs/numerics.md.
///
/// Lanes on several threads use one WallClock each, made with the same epoch, so that their instants compare.

#include <atomic>
#include <string>

#include "evenstep/clock/clock.h"

namespace evenstep {

/// CLOCK_MONOTONIC ns that RealTime{0} of a run stands for.
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

/// What the operating system granted to the calling thread.
struct RealTimeGrant {
  bool fifo = false;           ///< SCHED_FIFO at the priority asked for
  bool memory_locked = false;  ///< mlockall(MCL_CURRENT)
  std::string refusal;         ///< empty, or why not (errno text): the run is then marked "not real-time"
};
/// Timer slack 1 ns (always), SCHED_FIFO and mlockall where permitted, for the calling thread.
RealTimeGrant request_real_time(int fifo_priority);

/// Seconds of CPU this process has used (all threads): for run-time reports, never for decisions.
double process_cpu_seconds();
/// CLOCK_MONOTONIC seconds since an arbitrary origin: for run-time reports, never for decisions.
double monotonic_seconds();

}  // namespace evenstep
