#include "evenstep/device/force_guard.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace evenstep {
namespace {

/// Far above any force and far below where the difference of two could overflow.
constexpr double kLargestMax_N = 1e12;

double largest_component(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

/// The direction of v (not 0) with largest component +-1, so that no square overflows or vanishes.
glm::dvec3 direction(const glm::dvec3& v) {
  const double scale = largest_component(v);
  return {v.x / scale, v.y / scale, v.z / scale};
}

/// Between 1 and sqrt(3).
double direction_length(const glm::dvec3& d) { return std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z); }

bool longer(const glm::dvec3& v, double limit) {
  const double scale = largest_component(v);
  return scale > 0 && scale * direction_length(direction(v)) > limit;
}

glm::dvec3 shortened(const glm::dvec3& v, double length) {
  const glm::dvec3 d = direction(v);
  return d * (length / direction_length(d));
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
  if (!longer(change_N, max_change_N)) return last_N_ = target_N;
  ++counters_.slewed;
  return last_N_ += shortened(change_N, max_change_N);
}

glm::dvec3 ForceGuard::clamped(const glm::dvec3& wanted_N) {
  if (!is_finite(wanted_N)) {
    ++counters_.non_finite;
    return glm::dvec3(0);
  }
  if (!longer(wanted_N, limits_.max_N)) return wanted_N;
  ++counters_.clamped;
  return shortened(wanted_N, limits_.max_N);
}

}  // namespace evenstep
