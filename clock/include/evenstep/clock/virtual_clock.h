#pragma once
/// A clock that stands still until it is told to wait, then jumps: wait_until(t) sets now() to t and returns.
/// It starts at RealTime{0}. A wait that ends with a notification leaves now() where it is.

#include <atomic>

#include "evenstep/clock/clock.h"

namespace evenstep {

class VirtualClock final : public Clock {
 public:
  RealTime now() const noexcept override { return {now_ns_.load(std::memory_order_acquire)}; }
  Wake wait_until(RealTime deadline) noexcept override;
  /// An exchange, not a store: a plain store could hide what another thread wrote just before its own notify().
  void notify() noexcept override { notified_.exchange(true, std::memory_order_release); }
  bool is_virtual() const noexcept override { return true; }

 private:
  std::atomic<std::int64_t> now_ns_{0};
  std::atomic<bool> notified_{false};
};

}  // namespace evenstep
