#pragma once
/// The force side (paper, Figure 4): every step's response has an emission time F(n) = R(n) + L; the device tick asks for
/// the value at its own time. "hold" plays the latest F(n) <= tick; "linear" interpolates between F(n) and F(n+1) and
/// therefore needs one slot more latency (docs/choose/numerics.md).

#include <optional>

#include "evenstep/remap/extrapolation.h"
#include "evenstep/remap/sample.h"
#include "evenstep/remap/timed_ring.h"

namespace evenstep {

enum class Emission : std::uint8_t { hold, linear };

template <class Value>
class ForceSchedule {
 public:
  /// `past_newest` is the underrun policy of linear emission. Emission::hold ignores it: it plays the latest force that
  /// is due, so that none is ever missing. `spare`: see TimedRing.
  ForceSchedule(std::size_t capacity, Emission emission, Extrapolation past_newest = kHoldNewest, std::size_t spare = 0)
      : ring_(capacity, spare), emission_(emission), past_newest_(past_newest) {}

  /// Emission times must increase (SlotMap::emission_time repairs those of maps that step back).
  void push(RealTime emission, const Value& value) { ring_.push(emission, value); }
  std::uint64_t head() const { return ring_.head(); }
  std::size_t capacity() const { return ring_.capacity(); }
  Emission emission() const { return emission_; }

  /// When entry `index` (0 = first ever pushed) of the first `head` is due; empty if it is not yet, or no longer, in the
  /// ring.
  std::optional<RealTime> emission(std::uint64_t index, std::uint64_t head) const {
    typename TimedRing<Value>::Entry entry;
    return ring_.get(index, head, entry) ? std::optional(entry.time) : std::nullopt;
  }

  /// The value to send at `at`, seeing the first `head` entries. status:
  ///   inside    as scheduled
  ///   underrun  linear only: `at` lies past the last emission time known; value by the policy
  ///   empty     before the first emission time, or nothing pushed: Value{} (no force yet)
  ///   overrun   the entry needed has left the ring
  /// hold cannot see that an entry is missing (it only ever looks back): the step's own `late` says so.
  Reading<Value> at(RealTime at, std::uint64_t head) const;
  Reading<Value> at(RealTime time) const { return at(time, head()); }

 private:
  TimedRing<Value> ring_;
  Emission emission_;
  Extrapolation past_newest_;
};

template <class Value>
Reading<Value> ForceSchedule<Value>::at(RealTime at, std::uint64_t head) const {
  using Ring = TimedRing<Value>;
  typename Ring::Entry earlier{}, later;
  if (head == 0) return {};
  if (!ring_.get(head - 1, head, later)) return {Value{}, ReadStatus::overrun, {}};
  const RealTime newest = later.time;
  if (newest <= at) {
    const bool past = emission_ == Emission::linear && newest < at;
    if (past) return {value_beyond(ring_, head, later, at, past_newest_), ReadStatus::underrun, newest};
    return {later.value, ReadStatus::inside, newest};
  }
  const auto place = ring_.find(at, head, earlier, later);
  if (place == Ring::Place::before_first) return {Value{}, ReadStatus::empty, newest};
  if (place == Ring::Place::lost) return {later.value, ReadStatus::overrun, newest};
  if (emission_ == Emission::hold) return {earlier.value, ReadStatus::inside, newest};
  const double w = ratio(at - earlier.time, later.time - earlier.time);
  return {lerp(earlier.value, later.value, w), ReadStatus::inside, newest};
}

}  // namespace evenstep
