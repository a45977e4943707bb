#include "evenstep/device/force_guard.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace evenstep {
namespace {

/// Far above any force and far below where the difference of two could overflow.
constexpr double kLargestMax_N = 1e12;

/// A square that overflows gives infinity, longer than any limit; one that vanishes is of less than 1e-160 N.
double length(const glm::dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// v in the same direction with the length given. Divided by its largest component first, so that no square overflows.
glm::dvec3 shortened(const glm::dvec3& v, double new_length) {
  const double scale = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  const glm::dvec3 direction(v.x / scale, v.y / scale, v.z / scale);
  return direction * (new_length / length(direction));
}

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace

ForceGuard::ForceGuard(ForceLimits limits) : limits_(limits) {
  assert(limits.max_N > 0 && limits.max_N <= kLargestMax_N);
  assert(limits.max_slew_N_per_s > 0 && std::isfinite(limits.max_slew_N_per_s));
}

glm::dvec3 ForceGuard::pass(RealTime now, const glm::dvec3& wanted_N) {
  if (!started_) last_at_ = now;
  started_ = true;
  assert(now >= last_at_);
  const glm::dvec3 target_N = clamped(wanted_N);
  const glm::dvec3 change_N = target_N - last_N_;
  const double max_change_N = limits_.max_slew_N_per_s * seconds(now - last_at_);
  last_at_ = now;
  if (length(change_N) <= max_change_N) return last_N_ = target_N;
  ++counters_.slewed;
  return last_N_ += shortened(change_N, max_change_N);
}

glm::dvec3 ForceGuard::clamped(const glm::dvec3& wanted_N) {
  if (!is_finite(wanted_N)) {
    ++counters_.non_finite;
    return glm::dvec3(0);
  }
  if (length(wanted_N) <= limits_.max_N) return wanted_N;
  ++counters_.clamped;
  return shortened(wanted_N, limits_.max_N);
}

}  // namespace evenstep
