#pragma once
/// A fixed ring of (RealTime, Value) with one writer and one reader thread; no allocation after construction.
/// The writer publishes with a release-stored head; a reader says which head it reads at, because the head a read saw
/// is an input of a recorded run (the same head gives the same answer for ever, as long as the ring still holds it).
/// An overtaken read is an overrun, never a torn value, and never a data race: entries are atomic words, and a reader that
/// saw one word of a newer entry (acquire) also sees the head that was stored before it (release), checked after the copy.

#include <array>
#include <atomic>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>

#include "evenstep/time/time.h"

namespace evenstep {

template <class Value>
class TimedRing {
  static_assert(std::is_trivially_copyable_v<Value>);

 public:
  struct Entry {
    RealTime time;
    Value value;
  };
  /// capacity >= 2 entries readable at any moment.
  explicit TimedRing(std::size_t capacity)
      : capacity_(capacity), slots_(std::make_unique<Slot[]>(capacity + 1)) { assert(capacity >= 2); }

  std::size_t capacity() const { return capacity_; }
  /// Entries ever pushed.
  std::uint64_t head() const { return head_.load(std::memory_order_acquire); }

  /// Writer only. Times must not decrease.
  void push(RealTime time, const Value& value) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    std::array<std::uint64_t, kWords> words{};
    const Entry entry{time, value};
    std::memcpy(words.data(), &entry, sizeof(Entry));
    Slot& slot = slots_[head % (capacity_ + 1)];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
    head_.store(head + 1, std::memory_order_release);
  }

  /// Entry `index` (0 = first ever pushed). False if it is not yet, or no longer, in the ring.
  bool get(std::uint64_t index, Entry& entry) const {
    if (index >= head()) return false;
    std::array<std::uint64_t, kWords> words;
    const Slot& slot = slots_[index % (capacity_ + 1)];
    for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_acquire);
    // The writer may be filling entry `head` now; its slot held entry head - (capacity + 1), which is out of reach here.
    if (head_.load(std::memory_order_relaxed) - index > capacity_) return false;
    std::memcpy(static_cast<void*>(&entry), words.data(), sizeof(Entry));
    return true;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(Entry) + 7) / 8;
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;
  std::size_t capacity_;
  std::unique_ptr<Slot[]> slots_;
  std::atomic<std::uint64_t> head_{0};
};

}  // namespace evenstep
