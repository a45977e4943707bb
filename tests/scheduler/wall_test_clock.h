#pragma once
/// Two clocks that are not virtual: one real, and one whose time the test sets, for what must be exact.

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>

#include "evenstep/clock/clock.h"

namespace evenstep::test {

class SteadyTestClock final : public Clock {
 public:
  RealTime now() const noexcept override {
    return {std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - epoch_).count()};
  }
  Wake wait_until(RealTime deadline) noexcept override {
    std::unique_lock lock(mutex_);
    const auto notified = [this] { return notified_; };
    if (deadline == kNever) {
      wake_.wait(lock, notified);
    } else {
      wake_.wait_until(lock, epoch_ + std::chrono::nanoseconds(deadline.ns), notified);
    }
    if (!notified_) return Wake::deadline;
    notified_ = false;
    return Wake::notified;
  }
  void notify() noexcept override {
    const std::lock_guard lock(mutex_);
    notified_ = true;
    wake_.notify_one();
  }
  bool is_virtual() const noexcept override { return false; }

 private:
  const std::chrono::steady_clock::time_point epoch_ = std::chrono::steady_clock::now();
  std::mutex mutex_;
  std::condition_variable wake_;
  bool notified_ = false;
};

/// The wall clock under test: the one line to change for another.
inline std::unique_ptr<Clock> make_wall_clock() { return std::make_unique<SteadyTestClock>(); }

/// A wall clock that stands still: a wait jumps to its deadline, plus `lateness`, unless it was notified.
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
