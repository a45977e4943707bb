#pragma once
/// Always between the schedule and the device: clamps the magnitude (never zeroes a large force), limits the change per
/// second, and answers a non-finite force with a ramp to zero. Not a safety device.

#include <cstdint>

#include <glm/vec3.hpp>

#include "evenstep/time/time.h"

namespace evenstep {

struct ForceLimits {
  double max_N = 100;                    ///< of the vector's length; > 0
  double max_slew_N_per_s = 1e6;         ///< of the change's length; > 0
};

struct ForceGuardCounters {
  std::int64_t clamped = 0;
  std::int64_t slewed = 0;
  std::int64_t non_finite = 0;
};

class ForceGuard {
 public:
  explicit ForceGuard(ForceLimits limits) : limits_(limits) {}
  /// The force to send at `now`. Starts from zero force at the first call's time. `now` must not decrease.
  glm::dvec3 pass(RealTime now, const glm::dvec3& wanted_N);
  const ForceGuardCounters& counters() const { return counters_; }

 private:
  ForceLimits limits_;
  ForceGuardCounters counters_;
  glm::dvec3 last_N_{0};
  RealTime last_at_;
  bool started_ = false;
};

}  // namespace evenstep
