#include "evenstep/clock/virtual_clock.h"

namespace evenstep {

Wake VirtualClock::wait_until(RealTime deadline) noexcept {
  // A cheap load comes first because the exchange costs more than the rest of an event's wait.
  if (notified_.load(std::memory_order_relaxed) && notified_.exchange(false, std::memory_order_acq_rel)) {
    return Wake::notified;
  }
  if (deadline == kNever) return Wake::notified;
  if (deadline > now()) now_ns_.store(deadline.ns, std::memory_order_release);
  return Wake::deadline;
}

}  // namespace evenstep
