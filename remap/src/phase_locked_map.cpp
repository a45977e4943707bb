#include "evenstep/remap/phase_locked_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <utility>

namespace evenstep {
namespace {

constexpr double kMaxGain = 0.7;         // w; the loop is stable below 1.035 (docs/numerics.md)
constexpr double kMaxSlopeChange = 0.5;  // rho < 1: the map is strictly monotone
constexpr double kHang_segments = 8;     // a lag that would take 16 segments to catch up at 1.5 times the pace
constexpr double kLeastPeriod_ns = 1.0;
// How far T/N must be off P to count as another pace. For two segments in a row: 10 % jitter (3.7 % of T, and P itself
// moves by 2.5 %) never reached this limit in 10^6 segments; V halved or N doubled (16.7 %) does reach it. One segment
// alone must be further off: 10 % jitter reaches that limit 7 times in 10^6 segments.
constexpr double kNewPace = 0.16;
constexpr double kSamePace = 0.06;
constexpr double kOddSegment = 0.2;

double within_slope_change(double slope_ns, double period_ns) {
  return std::clamp(slope_ns, (1 - kMaxSlopeChange) * period_ns, (1 + kMaxSlopeChange) * period_ns);
}

}  // namespace

void PhaseLockedMap::boundary(std::int64_t n, RealTime begin) {
  assert(!started_ || (n >= first_step_ && begin >= boundary_));
  const std::int64_t steps = started_ ? n - first_step_ : 0;
  const bool acquiring = period_ns_ == 0;
  if (steps == 0 && !acquiring) return;
  if (steps > 0) {
    const double length_ns = static_cast<double>((begin - boundary_).ns);
    if (acquiring)
      acquire(begin, length_ns, static_cast<double>(steps));
    else
      track(begin, length_ns, static_cast<double>(steps));
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
  advance(steps);
  const double error_ns = static_cast<double>((begin - origin_).ns) - remainder_ns_;
  const double measured_ns = length_ns / steps;
  const double off = measured_ns / period_ns_ - 1;
  const Segment before = std::exchange(last_, {length_ns, steps, period_ns_});
  const bool restart = pace_moved(before, measured_ns);
  if (restart) {
    ++pace_changes_;
    period_ns_ = last_.period_ns = std::max((before.length_ns + length_ns) / (before.steps + steps), kLeastPeriod_ns);
  }
  const double w = std::min(2 * std::numbers::pi * bandwidth_Hz_ * period_ns_ * steps * 1e-9, kMaxGain);
  const LoopGains gains = loop_gains(w);
  const double pull_ns = gains.slope * error_ns / steps;
  if (std::abs(pull_ns) > kMaxSlopeChange * period_ns_) {
    relock(begin, error_ns, measured_ns, steps);
    return;
  }
  const bool phase_only = restart || closing(error_ns, w);
  closing_ns_ = phase_only ? error_ns : 0;
  if (!phase_only) period_ns_ += gains.period * error_ns / steps;
  slope_ns_ = within_slope_change(period_ns_ + pull_ns, period_ns_);
  const bool odd = std::abs(off) > kOddSegment && (off > 0) == (error_ns > 0);
  if (odd && std::abs(measured_ns - period_ns_) > std::abs(pull_ns)) {
    slope_ns_ = within_slope_change(measured_ns, period_ns_);
  }
}

/// phi <- slot(n), which keeps the map continuous.
void PhaseLockedMap::advance(double steps) {
  const double advanced_ns = remainder_ns_ + steps * slope_ns_;
  const double whole_ns = std::floor(advanced_ns);
  origin_ = origin_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = advanced_ns - whole_ns;
}

bool PhaseLockedMap::pace_moved(const Segment& before, double measured_ns) const {
  if (before.steps == 0) return false;
  const double first = before.length_ns / before.steps / before.period_ns - 1;
  const double second = measured_ns / before.period_ns - 1;
  return std::min(std::abs(first), std::abs(second)) > kNewPace && std::abs(first - second) < kSamePace;
}

/// Whether the error is still only one of phase. P was just measured, so as long as the error shrinks by at least half of
/// what the loop's pull on the phase alone would achieve, it says nothing about P.
bool PhaseLockedMap::closing(double error_ns, double w) const {
  const double shrunk = 1 - w / std::numbers::sqrt2;
  return error_ns * closing_ns_ > 0 && std::abs(error_ns) <= shrunk * std::abs(closing_ns_);
}

void PhaseLockedMap::relock(RealTime begin, double error_ns, double measured_ns, double steps) {
  period_ns_ = std::max(within_slope_change(measured_ns, period_ns_), kLeastPeriod_ns);
  slope_ns_ = period_ns_ * (error_ns > 0 ? 1 + kMaxSlopeChange : 1 - kMaxSlopeChange);
  closing_ns_ = error_ns;
  if (error_ns > kHang_segments * period_ns_ * steps) {
    origin_ = begin;
    remainder_ns_ = 0;
    slope_ns_ = period_ns_;
  }
}

inline RealTime PhaseLockedMap::slot_of(std::int64_t n) const {
  return origin_ + Duration{internal::floor_ns(remainder_ns_ + static_cast<double>(n - first_step_) * slope_ns_)};
}

std::optional<RealTime> PhaseLockedMap::slot(std::int64_t n) {
  if (period_ns_ == 0) return std::nullopt;
  return slot_of(n);
}

bool PhaseLockedMap::slots(std::int64_t n, std::span<RealTime> out) {
  if (period_ns_ == 0) return false;
  for (RealTime& one : out) one = slot_of(n++);
  return true;
}

}  // namespace evenstep
