#pragma once
/// The pending events in the order of the contract: (time, lane, sequence) packed into one 128-bit number, so that one
/// comparison orders two events. An array holds a heap with four children per node: it has half the levels of a binary
/// heap, the children of a node lie side by side, and nothing is allocated once the array has grown.
///
/// The lane whose event is being run almost always waits for something next. So taking the first event leaves a gap at
/// the root, which the next push fills: one walk down replaces a walk down and a walk up.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "evenstep/scheduler/lane.h"
#include "evenstep/scheduler/scheduler.h"
#include "evenstep/time/digest.h"
#include "evenstep/time/time.h"

namespace evenstep::internal {

inline constexpr int kSequenceBits = 56;  // 7e16 events: a run of 50 million events per second lasts 45 years
inline constexpr std::uint64_t kSequenceMask = (std::uint64_t{1} << kSequenceBits) - 1;

/// time (64 bits, sign flipped so that it orders unsigned) | lane (8) | sequence (56). Two words, compared as one number.
class EventKey {
 public:
  constexpr EventKey() = default;
  constexpr EventKey(RealTime time, Lane lane, std::uint64_t sequence)
      : high_(static_cast<std::uint64_t>(time.ns) ^ kSign),
        low_(static_cast<std::uint64_t>(lane) << kSequenceBits | (sequence & kSequenceMask)) {}
  /// Comes after every event.
  static constexpr EventKey past_all() {
    EventKey key;
    key.high_ = key.low_ = ~std::uint64_t{0};
    return key;
  }
  constexpr RealTime time() const { return {static_cast<std::int64_t>(high_ ^ kSign)}; }
  constexpr Lane lane() const { return static_cast<Lane>(low_ >> kSequenceBits); }
  friend constexpr bool operator<(EventKey a, EventKey b) { return a.number() < b.number(); }

 private:
  static constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  constexpr unsigned __int128 number() const { return static_cast<unsigned __int128>(high_) << 64 | low_; }
  std::uint64_t high_ = kSign;
  std::uint64_t low_ = 0;
};

/// Numbers the awaits in the order in which they were made. With a seed the numbers go through a bijection of 56-bit
/// numbers: no two become equal, and events that differ in time or lane keep their order.
class TieOrder {
 public:
  explicit TieOrder(std::optional<std::uint64_t> seed)
      : permute_(seed.has_value()), first_key_(spread(seed.value_or(0))), second_key_(spread(first_key_ + 1)) {}

  std::uint64_t next() {
    const std::uint64_t sequence = ++count_;
    return permute_ ? permuted(sequence) : sequence;
  }

 private:
  /// Adding, multiplying by an odd number and x ^= x >> k are each invertible modulo 2^56, so is their chain. Two keyed
  /// rounds of murmur3's multipliers.
  std::uint64_t permuted(std::uint64_t x) const {
    x = ((x + first_key_) * 0xff51afd7ed558ccdULL) & kSequenceMask;
    x ^= x >> 28;
    x = ((x + second_key_) * 0xc4ceb9fe1a85ec53ULL) & kSequenceMask;
    return x ^ (x >> 28);
  }

  bool permute_;
  std::uint64_t first_key_;
  std::uint64_t second_key_;
  std::uint64_t count_ = 0;
};

class EventQueue {
 public:
  struct Item {
    EventKey key = EventKey::past_all();
    Scheduler::Suspended* lane = nullptr;
  };

  std::size_t size() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// The first in the order. Not between take() and close_gap().
  const Item& top() const { return heap_.front(); }
  /// Removes the first, leaving a gap that the next push() fills.
  void take() {
    gap_ = true;
    --count_;
  }
  /// Call it after take(), before anything but push() and size().
  void close_gap() {
    if (gap_) fill_gap_with_last();
  }
  void push(EventKey key, Scheduler::Suspended& lane) {
    ++count_;
    if (!gap_) return add_leaf(key, &lane);
    gap_ = false;
    sink(key, &lane);
  }

 private:
  static constexpr std::size_t kChildren = 4;

  /// Which of two neighbours comes first. An addition, not a branch: the outcome cannot be predicted, and a mispredicted
  /// branch costs more than the whole comparison.
  static std::size_t first_of_two(const Item* heap, std::size_t i) { return i + (heap[i + 1].key < heap[i].key); }

  // The next two take an item in two parts: copied as a whole, its words would be stored apart and loaded together, which
  // stalls the processor.

  /// Puts an item into the gap at the root, or further down, where no child comes before it.
  void sink(EventKey key, Scheduler::Suspended* lane) {
    Item* const heap = heap_.data();
    std::size_t gap = 0;
    for (std::size_t child; (child = gap * kChildren + 1) < count_;) {
      const std::size_t a = first_of_two(heap, child), b = first_of_two(heap, child + 2);
      const std::size_t least = a + (b - a) * (heap[b].key < heap[a].key);
      if (key < heap[least].key) break;
      heap[gap] = heap[least];
      gap = least;
    }
    heap[gap].key = key;
    heap[gap].lane = lane;
  }
  /// Puts an item into a new last leaf, or further up, where its parent comes before it.
  [[gnu::noinline]] void add_leaf(EventKey key, Scheduler::Suspended* lane) {
    heap_.emplace_back();
    std::size_t gap = count_ - 1;
    while (gap > 0) {
      const std::size_t parent = (gap - 1) / kChildren;
      if (heap_[parent].key < key) break;
      heap_[gap] = heap_[parent];
      gap = parent;
    }
    heap_[gap].key = key;
    heap_[gap].lane = lane;
  }
  [[gnu::noinline]] void fill_gap_with_last() {
    gap_ = false;
    const Item last = heap_[count_];
    heap_[count_] = {};
    heap_.pop_back();
    if (count_ > 0) sink(last.key, last.lane);
  }

  std::size_t count_ = 0;
  std::vector<Item> heap_ = std::vector<Item>(kChildren - 1);  // count_ items, then past_all(): every group is complete
  bool gap_ = false;                                           // the root was taken: its place counts as one more item
};

}  // namespace evenstep::internal
