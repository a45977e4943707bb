#pragma once
/// A fixed ring of (RealTime, Value) with one writer and one reader thread; no allocation after construction.
/// The writer publishes an entry by a release store of the head. A reader says at which head it reads, because the head that
/// a read saw is an input of a recorded run: the same head gives the same answer, whatever was pushed since, as long as that
/// is not more than `spare`.
/// A read that the writer overtakes is an overrun, but never a torn value and never a data race: entries are atomic words,
/// and a reader that saw one word of a newer entry (acquire) also sees the head that was stored before it (release), which
/// is checked after the copy.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
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
  /// The last `capacity` >= 2 entries before a head are readable at it, until more than `spare` have been pushed since.
  explicit TimedRing(std::size_t capacity, std::size_t spare = 0)
      : capacity_(capacity),
        kept_(capacity + spare),
        mask_(std::bit_ceil(kept_ + 1) - 1),
        slots_(std::make_unique<Slot[]>(mask_ + 1)) {
    assert(capacity >= 2);
  }

  std::size_t capacity() const { return capacity_; }
  /// Entries ever pushed.
  std::uint64_t head() const { return head_.load(std::memory_order_acquire); }

  /// Writer only. Times must not decrease.
  void push(RealTime time, const Value& value) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    std::array<std::uint64_t, kWords> words{};
    const Entry entry{time, value};
    std::memcpy(words.data(), &entry, sizeof(Entry));
    Slot& slot = slots_[head & mask_];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_release);
    head_.store(head + 1, std::memory_order_release);
  }

  /// Entry `index` (0 = first ever pushed) as of `head`. False if it is not yet, or no longer, in the ring. (A difference
  /// below zero wraps round to a large number.)
  bool get(std::uint64_t index, std::uint64_t head, Entry& entry) const {
    if (head - index - 1 >= capacity_) return false;
    return copy(index, entry);
  }

  enum class Place {
    between,       ///< at `earlier` or after it, and before `later`
    before_first,  ///< before the first entry ever pushed, which is `later`
    lost,          ///< older than the ring holds; `later` is the oldest entry that it does
  };
  /// Which two neighbours of the first `head` entries `at` lies between. `later` is handed in as the newest of them and must
  /// lie after `at`. Of entries with equal times `earlier` is the last.
  ///
  /// Most reads lie near the newest entry, so the search doubles its distance from there and then halves the gap: an entry k
  /// back takes about 2 log2(k) looks. What the writer has overwritten by now counts as too old, which it is.
  Place find(RealTime at, std::uint64_t head, Entry& earlier, Entry& later) const {
    // Distances from the newest entry: the one at `after` lies after `at`, the one at `before` does not or is out of reach.
    std::uint64_t after = 0, before = std::min<std::uint64_t>(head, capacity_);
    bool found = false, doubling = true;
    for (std::uint64_t back = 1; before - after > 1;) {
      Entry entry;
      const bool there = copy(head - 1 - back, entry);
      if (there && at < entry.time) {
        later = entry;
        after = back;
      } else {
        if (there) earlier = entry;
        before = back;
        found = there;
        doubling = false;
      }
      back = doubling ? std::min(2 * back, before - 1) : after + (before - after) / 2;
    }
    if (found) return Place::between;
    return after == head - 1 ? Place::before_first : Place::lost;
  }

 private:
  static constexpr std::size_t kWords = (sizeof(Entry) + 7) / 8;
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;

  /// False if the writer may have begun to overwrite it.
  bool copy(std::uint64_t index, Entry& entry) const {
    const Slot& slot = slots_[index & mask_];
    std::array<std::uint64_t, kWords> words;
    for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_acquire);
    // The writer may be filling the entry after the newest. Its slot held an entry at least kept_ + 1 before, which is out
    // of reach here.
    if (head_.load(std::memory_order_relaxed) - index - 1 >= kept_) return false;
    std::memcpy(static_cast<void*>(&entry), words.data(), sizeof(Entry));
    return true;
  }

  // As many slots as the next power of two: an entry's slot is then a mask away, where a remainder would take a division.
  std::size_t capacity_, kept_, mask_;
  std::unique_ptr<Slot[]> slots_;
  std::atomic<std::uint64_t> head_{0};
};

}  // namespace evenstep
