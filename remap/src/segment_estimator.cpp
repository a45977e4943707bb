#include "evenstep/remap/segment_estimator.h"

#include <cassert>

namespace evenstep {

SegmentEstimator::SegmentEstimator(double weight) : weight_(weight) { assert(weight > 0 && weight <= 1); }

void SegmentEstimator::segment(Duration length) {
  const auto measured_ns = static_cast<double>(length.ns);
  length_ns_ = length_ns_ ? *length_ns_ + weight_ * (measured_ns - *length_ns_) : measured_ns;
}

}  // namespace evenstep
