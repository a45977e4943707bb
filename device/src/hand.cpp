#include "evenstep/device/hand.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

namespace evenstep {
namespace {

/// False also for a NaN.
bool within_reach(const glm::dvec3& x) {
  return std::abs(x.x) <= kHandReach_m && std::abs(x.y) <= kHandReach_m && std::abs(x.z) <= kHandReach_m;
}

}  // namespace

Hand::Hand(HandSpec spec, ProgrammedMotion path, Duration grid)
    : spec_(std::move(spec)),
      path_(std::move(path)),
      grid_(grid),
      phase_{{}, spec_.velocity_m_per_s, evenstep::position_m(path_, RealTime{0})} {
  phase_.position_m = phase_.path_m + spec_.offset_m;
  assert(grid_.ns > 0 && spec_.mass_kg > 0 && spec_.total_damping_N_s_per_m() >= 0 && spec_.total_stiffness_N_per_m() >= 0);
}

void Hand::feel(RealTime from, const glm::dvec3& force_N) {
  assert(changes_.empty() ? from >= at_ || from < RealTime{0} : from >= changes_.back().from);
  changes_.push_back({from, force_N});
}

RealTime Hand::step_end() const {
  const RealTime next_grid{(at_.ns / grid_.ns + 1) * grid_.ns};
  return changes_.empty() ? next_grid : std::min(next_grid, changes_.front().from);
}

Hand::Phase Hand::after(RealTime end) const {
  const double h = seconds(end - at_);
  if (h == 0) return phase_;
  const double mass = spec_.total_mass_kg(), damping = spec_.total_damping_N_s_per_m();
  const double stiffness = spec_.total_stiffness_N_per_m();
  const auto& [x, v, from_m] = phase_;
  const glm::dvec3 to_m = evenstep::position_m(path_, end);
  glm::dvec3 drive_N = force_N_ + spec_.push_N;
  if (spec_.arm) drive_N += (to_m - from_m) * (spec_.arm->damping_N_s_per_m / h);
  const glm::dvec3 half_m_per_s = v + (drive_N - (x - from_m) * stiffness - v * damping) * (h / (2 * mass));
  const glm::dvec3 there_m = x + half_m_per_s * h;
  const glm::dvec3 kick_m_per_s = (drive_N - (there_m - to_m) * stiffness) * (h / (2 * mass));
  return {there_m, (half_m_per_s + kick_m_per_s) / (1 + h * damping / (2 * mass)), to_m};
}

glm::dvec3 Hand::position_m(RealTime at) {
  for (;;) {
    // A change at or before this instant takes effect now; at negative times nothing has moved yet.
    while (!changes_.empty() && changes_.front().from <= at_) {
      force_N_ = changes_.front().force_N;
      changes_.pop_front();
    }
    const RealTime end = step_end();
    if (end > at) break;
    phase_ = after(end);
    at_ = end;
    if (!within_reach(phase_.position_m)) {
      throw HandDiverged(fmt::format("the hand is more than {:g} m away at {:.6g} s", kHandReach_m, seconds(at_)), at_);
    }
  }
  return at > at_ ? after(at).position_m : phase_.position_m;
}

}  // namespace evenstep
