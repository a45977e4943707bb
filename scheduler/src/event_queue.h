#pragma once
/// The pending events in the order of the contract: (time, lane, sequence) packed into one 128-bit number, so that an
/// event is compared once. A binary heap in an array: evenstep's own lanes keep fewer than 20 events pending, where it
/// stays within two cache lines a level; no allocation once the array has grown.

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

/// time (64 bits, sign flipped so that it orders unsigned) | lane (8) | sequence (56)
class EventKey {
 public:
  constexpr EventKey() = default;
  constexpr EventKey(RealTime time, Lane lane, std::uint64_t sequence)
      : bits_(static_cast<unsigned __int128>(static_cast<std::uint64_t>(time.ns) ^ kSign) << 64 |
              static_cast<std::uint64_t>(lane) << kSequenceBits | (sequence & kSequenceMask)) {}
  constexpr RealTime time() const { return {static_cast<std::int64_t>(static_cast<std::uint64_t>(bits_ >> 64) ^ kSign)}; }
  constexpr Lane lane() const { return static_cast<Lane>(static_cast<std::uint64_t>(bits_) >> kSequenceBits); }
  friend constexpr bool operator<(EventKey a, EventKey b) { return a.bits_ < b.bits_; }

 private:
  static constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  unsigned __int128 bits_ = 0;
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
    EventKey key;
    Scheduler::Suspended* lane = nullptr;
  };

  bool empty() const { return heap_.empty(); }
  std::size_t size() const { return heap_.size(); }
  const Item& top() const { return heap_.front(); }
  void push(EventKey key, Scheduler::Suspended& lane) {
    heap_.push_back({key, &lane});
    std::push_heap(heap_.begin(), heap_.end(), Later{});
  }
  Item pop() {
    std::pop_heap(heap_.begin(), heap_.end(), Later{});
    const Item item = heap_.back();
    heap_.pop_back();
    return item;
  }

 private:
  struct Later {  // a type, not a function: so that it is inlined
    bool operator()(const Item& a, const Item& b) const { return b.key < a.key; }
  };
  std::vector<Item> heap_;
};

}  // namespace evenstep::internal
