#include "former_maps.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace evenstep::bench {
namespace {

constexpr double kMaxGain = 0.7;  // the largest w; with P updated first the loop is stable below 1.035
constexpr double kLeastPeriod_ns = 1;
constexpr double kMaxSlopeChange = 0.5;
constexpr double kHang_segments = 8;
constexpr double kNewPace = 0.16;
constexpr double kSamePace = 0.06;
constexpr double kOddSegment = 0.2;

double within_slope_change(double slope_ns, double period_ns) {
  return std::clamp(slope_ns, (1 - kMaxSlopeChange) * period_ns, (1 + kMaxSlopeChange) * period_ns);
}

double gain(double bandwidth_Hz, double length_ns) {
  return std::min(2 * std::numbers::pi * bandwidth_Hz * length_ns * 1e-9, kMaxGain);
}
double pull_of(double w, double error_ns, double steps) { return std::numbers::sqrt2 * w * error_ns / steps; }

}  // namespace

void BoundaryLoop::boundary(std::int64_t n, RealTime begin) {
  const std::int64_t steps = started_ ? n - first_step_ : 0;
  if (steps == 0 && acquired_) return;
  if (steps > 0) {
    const double length_ns = static_cast<double>((begin - boundary_).ns), count = static_cast<double>(steps);
    if (acquired_) {
      advance(count);
      track(begin, static_cast<double>((begin - origin_).ns) - remainder_ns_, length_ns, count);
    } else {
      acquired_ = true;
      origin_ = begin;
      period_ns_ = slope_ns_ = std::max(length_ns / count, kLeastPeriod_ns);
    }
  }
  started_ = true;
  first_step_ = n;
  boundary_ = begin;
}

void BoundaryLoop::advance(double steps) {
  const double advanced_ns = remainder_ns_ + steps * slope_ns_;
  const double whole_ns = std::floor(advanced_ns);
  origin_ = origin_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = advanced_ns - whole_ns;
}

std::optional<RealTime> BoundaryLoop::slot(std::int64_t n) {
  if (!acquired_) return std::nullopt;
  return origin_ + Duration{internal::floor_ns(remainder_ns_ + static_cast<double>(n - first_step_) * slope_ns_)};
}

DelayLockedLoop::DelayLockedLoop(double bandwidth_Hz, Duration segment)
    : w_(gain(bandwidth_Hz, static_cast<double>(segment.ns))) {}

void DelayLockedLoop::track(RealTime, double error_ns, double, double steps) {
  slope_ns_ = period_ns_ + pull_of(w_, error_ns, steps);
  period_ns_ += w_ * w_ * error_ns / steps;
}

void BareLoop::track(RealTime, double error_ns, double, double steps) {
  const double w = gain(bandwidth_Hz_, period_ns_ * steps);
  period_ns_ = std::max(period_ns_ + w * w * error_ns / steps, kLeastPeriod_ns);
  slope_ns_ = period_ns_ + pull_of(w, error_ns, steps);
}

void FormerMap::track(RealTime begin, double error_ns, double length_ns, double steps) {
  const double measured_ns = length_ns / steps;
  const double off = measured_ns / period_ns_ - 1;
  const Segment before = std::exchange(last_, {length_ns, steps, period_ns_});
  const bool restart = pace_moved(before, measured_ns);
  if (restart)
    period_ns_ = last_.period_ns = std::max((before.length_ns + length_ns) / (before.steps + steps), kLeastPeriod_ns);
  const double w = gain(bandwidth_Hz_, period_ns_ * steps);
  const double pull_ns = pull_of(w, error_ns, steps);
  if (std::abs(pull_ns) > kMaxSlopeChange * period_ns_) return relock(begin, error_ns, measured_ns, steps);
  const bool phase_only = restart || closing(error_ns, w);
  closing_ns_ = phase_only ? error_ns : 0;
  if (!phase_only) period_ns_ += w * w * error_ns / steps;
  slope_ns_ = within_slope_change(period_ns_ + pull_ns, period_ns_);
  const bool odd = std::abs(off) > kOddSegment && (off > 0) == (error_ns > 0);
  if (odd && std::abs(measured_ns - period_ns_) > std::abs(pull_ns))
    slope_ns_ = within_slope_change(measured_ns, period_ns_);
}

bool FormerMap::pace_moved(const Segment& before, double measured_ns) const {
  if (before.steps == 0) return false;
  const double first = before.length_ns / before.steps / before.period_ns - 1;
  const double second = measured_ns / before.period_ns - 1;
  return std::min(std::abs(first), std::abs(second)) > kNewPace && std::abs(first - second) < kSamePace;
}

bool FormerMap::closing(double error_ns, double w) const {
  const double shrunk = 1 - w / std::numbers::sqrt2;
  return error_ns * closing_ns_ > 0 && std::abs(error_ns) <= shrunk * std::abs(closing_ns_);
}

void FormerMap::relock(RealTime begin, double error_ns, double measured_ns, double steps) {
  period_ns_ = std::max(within_slope_change(measured_ns, period_ns_), kLeastPeriod_ns);
  slope_ns_ = period_ns_ * (error_ns > 0 ? 1 + kMaxSlopeChange : 1 - kMaxSlopeChange);
  closing_ns_ = error_ns;
  if (error_ns > kHang_segments * period_ns_ * steps) {
    origin_ = begin;
    remainder_ns_ = 0;
    slope_ns_ = period_ns_;
  }
}

}  // namespace evenstep::bench
