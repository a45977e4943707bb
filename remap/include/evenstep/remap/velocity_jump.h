#pragma once
/// The largest velocity jump of a map: max of |R(n+1) - 2 R(n) + R(n-1)| over mapped steps. (A constant lead cancels, so
/// slots do as well as reads.) `evenstep size` gives it in mean slots, for the steps after the first second, or the first
/// half.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "evenstep/remap/latency_budget.h"

namespace evenstep {

/// The jump of the steps that begin at `from` or later; steps in order, a few at a time. 0 for fewer than three.
class VelocityJump {
 public:
  explicit VelocityJump(RealTime from) : from_(from) {}
  void add(std::span<const MappedStep> steps) {
    for (const MappedStep& step : steps) {
      if (step.begin < from_) continue;
      if (seen_ >= 2) most_ns_ = std::max(most_ns_, std::abs((step.slot - last_).ns - (last_ - before_).ns));
      ++seen_;
      before_ = last_;
      last_ = step.slot;
    }
  }
  std::int64_t most_ns() const { return most_ns_; }
  bool seen() const { return seen_ >= 3; }  ///< whether there was a jump to look at, of any size

 private:
  RealTime from_, before_, last_;
  std::int64_t seen_ = 0, most_ns_ = 0;
};

}  // namespace evenstep
