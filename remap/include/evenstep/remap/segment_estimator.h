#pragma once
/// The paper's estimate of a segment's length: "a weighted average of several successive time-segments" (section 3).
/// T^(k+1) = T^(k) + w (T(k) - T^(k)), for use in segment k + 1. The first estimate is the length of the first complete
/// segment, not a nominal length.

#include <optional>

#include "evenstep/time/time.h"

namespace evenstep {

class SegmentEstimator {
 public:
  explicit SegmentEstimator(double weight);  ///< 0 < weight <= 1; 1 = the last segment only
  void segment(Duration length);
  std::optional<double> length_ns() const { return length_ns_; }

 private:
  double weight_;
  std::optional<double> length_ns_;
};

}  // namespace evenstep
