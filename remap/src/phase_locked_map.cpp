#include "evenstep/remap/phase_locked_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace evenstep {
namespace {

constexpr double kMaxGain = 0.7;          // w; the loop is stable below 1.035 (docs/numerics.md)
constexpr double kMaxSlopeChange = 0.5;   // rho < 1: the map is strictly monotone
constexpr double kHang_segments = 8;      // a lag that would take 16 segments to catch up at 1.5 times the pace
constexpr double kLeastPeriod_ns = 1.0;

}  // namespace

void PhaseLockedMap::boundary(std::int64_t n, RealTime begin) {
  assert(!started_ || (n >= first_step_ && begin >= boundary_));
  const std::int64_t steps = started_ ? n - first_step_ : 0;
  const bool acquiring = period_ns_ == 0;
  if (steps == 0 && !acquiring) return;
  if (steps > 0) {
    const double length_ns = static_cast<double>((begin - boundary_).ns);
    if (acquiring) acquire(begin, length_ns, static_cast<double>(steps));
    else track(begin, length_ns, static_cast<double>(steps));
  }
  started_ = true;
  first_step_ = n;
  boundary_ = begin;
}

void PhaseLockedMap::acquire(RealTime begin, double length_ns, double steps) {
  origin_ = begin;
  remainder_ns_ = 0;
  period_ns_ = slope_ns_ = std::max(length_ns / steps, kLeastPeriod_ns);
}

void PhaseLockedMap::track(RealTime begin, double length_ns, double steps) {
  const double advanced_ns = remainder_ns_ + steps * slope_ns_;   // phi <- slot(n): continuous
  const double whole_ns = std::floor(advanced_ns);
  origin_ = origin_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = advanced_ns - whole_ns;

  const double error_ns = static_cast<double>((begin - origin_).ns) - remainder_ns_;
  const double w = std::min(2 * std::numbers::pi * bandwidth_Hz_ * period_ns_ * steps * 1e-9, kMaxGain);
  const double pull_ns = std::numbers::sqrt2 * w * error_ns / steps;
  if (std::abs(pull_ns) > kMaxSlopeChange * period_ns_) {
    relock(begin, error_ns, length_ns, steps);
    return;
  }
  period_ns_ += w * w * error_ns / steps;
  slope_ns_ = std::clamp(period_ns_ + pull_ns, (1 - kMaxSlopeChange) * period_ns_, (1 + kMaxSlopeChange) * period_ns_);
}

void PhaseLockedMap::relock(RealTime begin, double error_ns, double length_ns, double steps) {
  period_ns_ = std::clamp(length_ns / steps, (1 - kMaxSlopeChange) * period_ns_, (1 + kMaxSlopeChange) * period_ns_);
  period_ns_ = std::max(period_ns_, kLeastPeriod_ns);
  slope_ns_ = period_ns_ * (error_ns > 0 ? 1 + kMaxSlopeChange : 1 - kMaxSlopeChange);
  if (error_ns > kHang_segments * period_ns_ * steps) {
    origin_ = begin;
    remainder_ns_ = 0;
    slope_ns_ = period_ns_;
  }
}

std::optional<RealTime> PhaseLockedMap::slot(std::int64_t n) {
  if (period_ns_ == 0) return std::nullopt;
  const double into_segment_ns = remainder_ns_ + static_cast<double>(n - first_step_) * slope_ns_;
  return origin_ + Duration{static_cast<std::int64_t>(std::floor(into_segment_ns))};
}

}  // namespace evenstep
