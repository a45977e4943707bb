#include "evenstep/remap/paper_map.h"

#include <cassert>

namespace evenstep {

void PaperMap::boundary(std::int64_t n, RealTime begin) {
  assert(!started_ || (n >= first_step_ && begin >= begin_));
  if (started_ && n > first_step_) {
    estimator_.segment(begin - begin_);
    const auto steps = static_cast<double>(n - first_step_);
    step_count_ += step_count_ == 0 ? steps : count_weight_ * (steps - step_count_);
  }
  started_ = true;
  first_step_ = n;
  begin_ = begin;
}

std::optional<RealTime> PaperMap::slot(std::int64_t n) {
  if (step_count_ == 0) return std::nullopt;
  const double into_segment_ns = static_cast<double>(n - first_step_) * *estimator_.length_ns() / step_count_;
  return begin_ + Duration{internal::floor_ns(into_segment_ns)};
}

}  // namespace evenstep
