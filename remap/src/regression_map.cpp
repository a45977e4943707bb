#include "evenstep/remap/regression_map.h"

#include <algorithm>
#include <cmath>

namespace evenstep {

RegressionMap::RegressionMap(Rate step_rate, Duration lead, const AdaptiveLatency& latency, double forgetting_Hz)
    : SlotMap(lead, latency),
      keep_(std::max(0.5, 1 - forgetting_Hz * static_cast<double>(step_rate.den) / static_cast<double>(step_rate.num))) {}

void RegressionMap::boundary(std::int64_t n, RealTime) {
  complete_ = complete_ || (first_step_ >= 0 && n > first_step_);
  if (first_step_ < 0) first_step_ = n;
}

void RegressionMap::began(std::int64_t, RealTime begin) {
  if (!started_) {
    started_ = true;
    origin_ = last_slot_ = begin;
  } else {
    remainder_ns_ += slope_ns_;
    p00_ += 2 * p01_ + p11_;
    p01_ += p11_;
  }
  const double gain0 = p00_ / (keep_ + p00_), gain1 = p01_ / (keep_ + p00_);
  const double error_ns = static_cast<double>((begin - origin_).ns) - remainder_ns_;
  const double line_ns = remainder_ns_ + gain0 * error_ns;
  slope_ns_ += gain1 * error_ns;
  p11_ = (p11_ - gain1 * p01_) / keep_;
  p01_ = (p01_ - gain0 * p01_) / keep_;
  p00_ = (p00_ - gain0 * p00_) / keep_;
  const double whole_ns = std::floor(line_ns);
  origin_ = origin_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = line_ns - whole_ns;
}

std::optional<RealTime> RegressionMap::slot(std::int64_t) {
  if (!complete_) return std::nullopt;
  last_slot_ = std::max(last_slot_, origin_);
  return last_slot_;
}

}  // namespace evenstep
