#pragma once
/// A histogram of durations in fixed memory (15 KB), without allocation: for work that is timed millions of times and must
/// not be disturbed by the timing. Bins are 1 ns wide below 64 ns and 1/32 of their octave above, so a quantile is at most
/// 1/32 (3.2 %) above the exact one and never below it. Count, smallest and largest are exact.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "evenstep/time/time.h"

namespace evenstep {

class DurationHistogram {
 public:
  /// A negative duration counts as 0.
  void add(Duration duration) {
    const std::int64_t ns = std::max<std::int64_t>(0, duration.ns);
    ++bins_[bin_of(ns)];
    smallest_ = count_ == 0 ? ns : std::min(smallest_, ns);
    largest_ = std::max(largest_, ns);
    ++count_;
  }

  std::int64_t count() const { return count_; }
  Duration smallest() const { return {smallest_}; }  ///< 0 when empty
  Duration largest() const { return {largest_}; }    ///< 0 when empty

  /// The least duration that at least ceil(`permille` / 1000 * count) of the durations do not exceed, rounded up to the end
  /// of its bin; 0 when empty. `permille` in [0, 1000]; 0 gives the smallest.
  Duration quantile(int permille) const {
    const std::int64_t wanted = (count_ * permille + 999) / 1000;
    if (wanted == 0) return smallest();
    std::int64_t seen = 0;
    for (std::size_t bin = 0; bin < bins_.size(); ++bin) {
      seen += bins_[bin];
      if (seen >= wanted) return {std::min(last_of(bin), largest_)};
    }
    return largest();
  }

 private:
  static constexpr int kBits = 5;  // 32 bins per octave
  static constexpr std::int64_t kPerOctave = 1 << kBits;

  static std::size_t bin_of(std::int64_t ns) {
    if (ns < kPerOctave) return static_cast<std::size_t>(ns);
    const int shift = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(ns))) - 1 - kBits;
    return static_cast<std::size_t>((shift << kBits) + (ns >> shift));
  }
  static std::int64_t last_of(std::size_t bin) {
    const auto index = static_cast<std::int64_t>(bin);
    if (index < 2 * kPerOctave) return index;
    const std::int64_t shift = index / kPerOctave - 1;
    // Added in this order, the last bin ends at the largest int64 and does not overflow.
    return ((index - shift * kPerOctave) << shift) + ((std::int64_t{1} << shift) - 1);
  }

  std::array<std::int64_t, ((63 - kBits) << kBits) + kPerOctave> bins_{};
  std::int64_t count_ = 0, smallest_ = 0, largest_ = 0;
};

}  // namespace evenstep
