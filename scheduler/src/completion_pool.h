#pragma once
/// Started work, at addresses that do not change: an executor's thread holds a reference until it has set `done`.

#include <atomic>
#include <cstdint>
#include <deque>

#include "evenstep/scheduler/scheduler.h"
#include "evenstep/scheduler/work.h"

namespace evenstep::internal {

struct InFlight : Completion {
  Scheduler::Suspended* lane = nullptr;
  RealTime programmed_end;
  std::uint64_t sequence = 0;
  InFlight* next = nullptr;  // in the inbox, later in the pool's list
};

/// Finished entries are reused first in, first out, and only after their executor has let go of them.
class CompletionPool {
 public:
  InFlight& take() {
    if (oldest_ == nullptr || !oldest_->done.load(std::memory_order_acquire)) return entries_.emplace_back();
    InFlight& entry = *oldest_;
    oldest_ = entry.next;
    entry.next = nullptr;
    entry.done.store(false, std::memory_order_relaxed);
    return entry;
  }
  void give_back(InFlight& entry) {
    entry.next = nullptr;
    (oldest_ == nullptr ? oldest_ : newest_->next) = &entry;
    newest_ = &entry;
  }
  std::deque<InFlight>& entries() { return entries_; }

 private:
  std::deque<InFlight> entries_;
  InFlight* oldest_ = nullptr;
  InFlight* newest_ = nullptr;
};

/// Finished work on its way from the executors' threads to the scheduler's: many writers, one reader, no lock.
class Inbox {
 public:
  void push(InFlight& entry) noexcept {
    entry.next = newest_.load(std::memory_order_relaxed);
    while (!newest_.compare_exchange_weak(entry.next, &entry, std::memory_order_release, std::memory_order_relaxed)) {
    }
  }
  bool any() const noexcept { return newest_.load(std::memory_order_relaxed) != nullptr; }
  /// All entries, newest first; the order of events comes from their keys.
  InFlight* take_all() noexcept { return newest_.exchange(nullptr, std::memory_order_acquire); }

 private:
  std::atomic<InFlight*> newest_{nullptr};
};

}  // namespace evenstep::internal
