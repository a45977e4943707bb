#include "evenstep/device/force_guard.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace evenstep {
namespace {

/// Far above any real force, and far below the values whose differences could overflow.
constexpr double kLargestMax_N = 1e12;

/// If a square overflows, the length is infinite and so longer than any limit; if it vanishes, the force is below 1e-160 N.
double length(const glm::dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// v with a new length. It is divided by its largest component first, so that no square overflows.
glm::dvec3 shortened(const glm::dvec3& v, double new_length) {
  const double scale = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  const glm::dvec3 direction(v.x / scale, v.y / scale, v.z / scale);
  return direction * (new_length / length(direction));
}

/// The speed of a hand is its mean velocity over this time, because a single count of a coarse encoder within one tick says
/// nothing about the speed.
constexpr Duration kSpeedWindow{5'000'000};

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

std::int64_t& counter_of(GuardState reason, ForceGuardCounters& counters) {
  if (reason == GuardState::cut_device) return counters.cuts_device;
  if (reason == GuardState::cut_stale_hand) return counters.cuts_stale_hand;
  return reason == GuardState::cut_stale_force ? counters.cuts_stale_force : counters.cuts_speed;
}

}  // namespace

ForceGuard::ForceGuard(ForceLimits limits) : limits_(limits) {
  assert(limits.max_N > 0 && limits.max_N <= kLargestMax_N);
  assert(limits.max_slew_N_per_s > 0 && std::isfinite(limits.max_slew_N_per_s));
  assert(limits.cut.gain > 0 && limits.cut.gain <= 1 && limits.cut.max_speed_m_per_s > 0);
  assert(limits.cut.ramp_up.ns >= 0 && limits.cut.ramp_down.ns >= 0);
}

glm::dvec3 ForceGuard::pass(RealTime now, const glm::dvec3& wanted_N, const GuardedTick& tick) {
  if (!started_) last_at_ = now;
  started_ = true;
  assert(now >= last_at_);
  follow_hand(tick.sample);
  move_authority(now, tick);
  if (tick.sample.away) {
    authority_ = 0;
    last_N_ = glm::dvec3(0);
  }
  limited_ = {.cut = authority_ < 1};
  const glm::dvec3 target_N = clamped(wanted_N * limits_.cut.gain) * authority_;
  const glm::dvec3 change_N = target_N - last_N_;
  const double max_change_N = limits_.max_slew_N_per_s * seconds(now - last_at_);
  last_at_ = now;
  if (length(change_N) <= max_change_N) return last_N_ = target_N;
  ++counters_.slewed;
  limited_.slewed = true;
  return last_N_ += shortened(change_N, max_change_N);
}

glm::dvec3 ForceGuard::clamped(const glm::dvec3& wanted_N) {
  if (!is_finite(wanted_N)) {
    ++counters_.non_finite;
    limited_.non_finite = true;
    return glm::dvec3(0);
  }
  if (length(wanted_N) <= limits_.max_N) return wanted_N;
  ++counters_.clamped;
  limited_.clamped = true;
  return shortened(wanted_N, limits_.max_N);
}

DeviceSpring ForceGuard::share(const DeviceSpring& wanted) const {
  DeviceSpring shared;
  const double share = limits_.cut.gain * authority_;
  int axes = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double below = wanted.below_N_per_m[axis], above = wanted.above_N_per_m[axis];
    if (below + above == 0 || !std::isfinite(below + above + wanted.center_m[axis])) continue;
    ++axes;
    shared.center_m[axis] = wanted.center_m[axis];
    shared.below_N_per_m[axis] = below * share;
    shared.above_N_per_m[axis] = above * share;
    shared.limit_N[axis] = std::min(wanted.limit_N[axis], limits_.max_N) * authority_;
  }
  if (axes > 1) shared.limit_N /= std::sqrt(static_cast<double>(axes));
  return shared;
}

void ForceGuard::follow_hand(const DeviceSample& sample) {
  if (!sample.fresh) return;
  const std::size_t kept = std::min(fresh_samples_, hand_.size());
  // The oldest sample in the window, or the last sample if none is in it.
  for (std::size_t back = kept; back >= 1; --back) {
    const Position& then = hand_[(fresh_samples_ - back) % hand_.size()];
    const Duration since = sample.time() - then.at;
    if (since.ns <= 0 || (since > kSpeedWindow && back > 1)) continue;
    const double speed_m_per_s = length(sample.position_m - then.m) / seconds(since);
    const double limit_m_per_s = limits_.cut.max_speed_m_per_s;
    too_fast_ = !(speed_m_per_s <= (too_fast_ ? limit_m_per_s / 2 : limit_m_per_s));
    break;
  }
  hand_[fresh_samples_++ % hand_.size()] = {sample.time(), sample.position_m};
}

GuardState ForceGuard::state() const {
  if (reason_ == GuardState::cut_stale_force && !any_force_) return GuardState::waiting;
  return reason_ == GuardState::armed && authority_ < 1 ? GuardState::ramping : reason_;
}

/// The first reason for a cut; `armed` if there is none.
GuardState ForceGuard::reason_to_cut(RealTime now, const GuardedTick& tick) const {
  const RealTime last_fresh = fresh_samples_ == 0 ? RealTime{} : hand_[(fresh_samples_ - 1) % hand_.size()].at;
  if (!tick.sample.drivable) return GuardState::cut_device;
  if (now - last_fresh > limits_.cut.stale_hand) return GuardState::cut_stale_hand;
  if (!tick.force_due || now - *tick.force_due > limits_.cut.stale_force) return GuardState::cut_stale_force;
  if (too_fast_) return GuardState::cut_speed;
  return GuardState::armed;
}

void ForceGuard::move_authority(RealTime now, const GuardedTick& tick) {
  const bool was_cut = reason_ != GuardState::armed;
  reason_ = reason_to_cut(now, tick);
  any_force_ = any_force_ || tick.force_due;
  const bool cut = reason_ != GuardState::armed;
  if (cut && !was_cut && authority_ > 0) ++counter_of(reason_, counters_);
  const Duration ramp = cut ? limits_.cut.ramp_down : limits_.cut.ramp_up;
  const double most = ramp.ns == 0 ? 1.0 : static_cast<double>((now - last_at_).ns) / static_cast<double>(ramp.ns);
  authority_ = cut ? std::max(0.0, authority_ - most) : std::min(1.0, authority_ + most);
}

}  // namespace evenstep
