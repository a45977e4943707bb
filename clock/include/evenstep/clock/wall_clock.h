#pragma once
/// A clock that counts CLOCK_MONOTONIC from an epoch. It waits on a futex with an absolute time-out (a finished GPU kernel
/// could not wake clock_nanosleep) and spins for the last part of the wait, still watching for notifications.
/// docs/choose/numerics.md has the measurements behind this.
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
  /// The instant of a CLOCK_MONOTONIC reading, such as the kernel's time stamp of an event; clamped to the range of
  /// RealTime.
  RealTime at(std::int64_t monotonic_ns) const noexcept;

 private:
  WallEpoch epoch_;
  Duration spin_tail_;
  std::atomic<std::uint32_t> notified_{0};  // the futex word
};

/// What the operating system has granted a thread.
struct RealTimeGrant {
  int priority = 0;                 ///< the SCHED_FIFO priority asked for
  bool fifo = false;                ///< SCHED_FIFO at that priority
  std::int64_t timer_slack_ns = 0;  ///< how late the kernel may wake the thread to save power
  std::int64_t slice_ns = 0;        ///< without SCHED_FIFO, the time slice that was granted; 0: the system's own
  std::string refusal;              ///< empty, or why SCHED_FIFO was refused (errno text): the run is marked "not real-time"
};
/// The real-time rights of the thread that makes this, until it is destroyed by the same thread: SCHED_FIFO, if that is
/// permitted, and a timer slack of 1 ns, which always is. The destructor gives both back, so that what follows a live run
/// does not keep other programs from running. A thread that it starts meanwhile inherits the priority.
class RealTimeRights {
 public:
  explicit RealTimeRights(int fifo_priority);
  ~RealTimeRights();
  RealTimeRights(const RealTimeRights&) = delete;
  RealTimeRights& operator=(const RealTimeRights&) = delete;
  const RealTimeGrant& grant() const { return grant_; }

 private:
  RealTimeGrant grant_;
  int policy_before_, priority_before_, slack_before_ns_;
};

/// Keeps what the process has in memory now from being paged out (mlockall), if that is permitted, until it is destroyed.
/// What is allocated later is not locked: that would pin every later stack and GPU mapping, or fail at the limit.
class MemoryLock {
 public:
  MemoryLock();
  ~MemoryLock();
  MemoryLock(const MemoryLock&) = delete;
  MemoryLock& operator=(const MemoryLock&) = delete;
  const std::string& refusal() const { return refusal_; }  ///< empty: it is locked

 private:
  std::string refusal_;
};

/// Until it is destroyed, asks the kernel to let no core sleep so deeply that waking takes more than `most_us`: 0 keeps
/// every core from sleeping at all (Documentation/power/pm_qos_interface in the kernel's sources). The request holds as long
/// as the device is open.
class WakeLatency {
 public:
  explicit WakeLatency(std::int32_t most_us = 0, const std::string& device = "/dev/cpu_dma_latency");
  ~WakeLatency();
  WakeLatency(const WakeLatency&) = delete;
  WakeLatency& operator=(const WakeLatency&) = delete;
  const std::string& refusal() const { return refusal_; }  ///< empty: it is granted

 private:
  int file_ = -1;
  std::string refusal_;
};

/// Gives the calling thread ordinary priority: it may have inherited a real-time one from the thread that started it.
void leave_real_time();

/// CPU time that this process has used, s, all threads together: for run-time reports, never for decisions.
double process_cpu_seconds();
/// CLOCK_MONOTONIC, s since an arbitrary origin: for run-time reports, never for decisions.
double monotonic_seconds();
/// CLOCK_REALTIME, whole s since 1970-01-01 UTC: the date of a report, never for decisions.
std::int64_t unix_seconds();

}  // namespace evenstep
