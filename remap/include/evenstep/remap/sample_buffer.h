#pragma once
/// The interaction buffer (paper, Figure 3 a): samples of the hand in real time, read by linear interpolation at the time of
/// a slot. The result says whether the buffer really contained that time; for a read past the newest sample the buffer's
/// underrun policy gives the value.

#include "evenstep/remap/extrapolation.h"
#include "evenstep/remap/sample.h"
#include "evenstep/remap/slot_map.h"
#include "evenstep/remap/timed_ring.h"

namespace evenstep {

template <class Value>
class SampleBuffer {
 public:
  /// `spare`: see TimedRing.
  explicit SampleBuffer(std::size_t capacity, Extrapolation past_newest = kHoldNewest, std::size_t spare = 0)
      : ring_(capacity, spare), past_newest_(past_newest) {}

  void push(RealTime read_at, const Value& value) { ring_.push(read_at, value); }
  std::uint64_t head() const { return ring_.head(); }
  std::size_t capacity() const { return ring_.capacity(); }

  /// The value at `at`, seeing the first `head` entries only. Past the newest of them: `underrun`, value by the policy.
  /// Before the first entry ever pushed: the value of that entry, because the hand is taken to have been there already.
  Reading<Value> at(RealTime at, std::uint64_t head) const;
  Reading<Value> at(RealTime time) const { return at(time, head()); }
  /// The newest of the first `head` entries ("direct").
  Reading<Value> newest(std::uint64_t head) const;
  /// What a step with this slot reads: the value at R(n) (Figure 3 a), or the newest if the slot is not mapped.
  Reading<Value> hand(const Slot& slot, std::uint64_t head) const {
    return slot.kind == SlotKind::mapped ? at(slot.read, head) : newest(head);
  }

 private:
  TimedRing<Value> ring_;
  Extrapolation past_newest_;
};

template <class Value>
Reading<Value> SampleBuffer<Value>::newest(std::uint64_t head) const {
  typename TimedRing<Value>::Entry entry;
  if (head == 0) return {};
  if (!ring_.get(head - 1, head, entry)) return {Value{}, ReadStatus::overrun, {}};
  return {entry.value, ReadStatus::inside, entry.time};
}

template <class Value>
Reading<Value> SampleBuffer<Value>::at(RealTime at, std::uint64_t head) const {
  using Ring = TimedRing<Value>;
  typename Ring::Entry earlier{}, later;
  if (head == 0) return {};
  if (!ring_.get(head - 1, head, later)) return {Value{}, ReadStatus::overrun, {}};
  const RealTime newest = later.time;
  if (at > newest) return {value_beyond(ring_, head, later, at, past_newest_), ReadStatus::underrun, newest};
  if (at == newest) return {later.value, ReadStatus::inside, newest};
  const typename Ring::Place place = ring_.find(at, head, earlier, later);
  if (place == Ring::Place::before_first) return {later.value, ReadStatus::inside, newest};
  if (place == Ring::Place::lost) return {later.value, ReadStatus::overrun, newest};
  const double w = ratio(at - earlier.time, later.time - earlier.time);
  return {lerp(earlier.value, later.value, w), ReadStatus::inside, newest};
}

}  // namespace evenstep
