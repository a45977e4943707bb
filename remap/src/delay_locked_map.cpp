#include "evenstep/remap/delay_locked_map.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace evenstep {
namespace {

constexpr double kMostTurn = 0.5;  // w
constexpr double kLeast_ns = 1, kMost_ns = 1e12;

}  // namespace

void DelayLockedMap::boundary(std::int64_t n, RealTime begin) {
  assert(!started_ || n >= first_step_);
  const auto steps = static_cast<double>(n - first_step_);
  if (started_ && steps == 0) return;
  const bool acquiring = slot_ns_ == 0;
  if (started_ && acquiring) {
    const double length_ns = static_cast<double>((begin - origin_).ns);
    slot_ns_ = period_ns_ = std::clamp(length_ns / steps, kLeast_ns, kMost_ns);
    turn_ = std::min(2 * std::numbers::pi * bandwidth_Hz_ * length_ns * 1e-9, kMostTurn);
  }
  started_ = true;
  first_step_ = n;
  if (acquiring) {
    origin_ = begin;
    return;
  }
  const double end_ns = remainder_ns_ + steps * slot_ns_;  // t1, from origin_ on
  const double error_ns = static_cast<double>((begin - origin_).ns) - end_ns;
  const double whole_ns = std::floor(end_ns);
  origin_ = origin_ + Duration{static_cast<std::int64_t>(whole_ns)};
  remainder_ns_ = end_ns - whole_ns;
  slot_ns_ = std::clamp(period_ns_ + std::numbers::sqrt2 * turn_ * error_ns / steps, kLeast_ns, kMost_ns);
  period_ns_ = std::clamp(period_ns_ + turn_ * turn_ * error_ns / steps, kLeast_ns, kMost_ns);
}

std::optional<RealTime> DelayLockedMap::slot(std::int64_t n) {
  if (slot_ns_ == 0) return std::nullopt;
  const double into_ns = remainder_ns_ + static_cast<double>(n - first_step_) * slot_ns_;
  return origin_ + Duration{internal::floor_ns(into_ns)};
}

}  // namespace evenstep
