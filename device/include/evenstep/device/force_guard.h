#pragma once
/// Always between the schedule and the device: clamps the magnitude (never zeroes a large force), limits the change per
/// second, and answers a non-finite force with a ramp to zero. Not a safety device.
///
///   target = wanted, shortened to max_N; 0 where wanted is not finite
///   sent   = last sent + (target - last sent), shortened to max_slew_N_per_s * (now - time of the last call)
///
/// A force that exceeds neither limit passes bit for bit; a limited one keeps its direction and may be longer than the
/// limit by rounding (a few 1e-16 of it). A call at the instant of the last one may not change the force.

#include <cstdint>

#include <glm/vec3.hpp>

#include "evenstep/time/time.h"

namespace evenstep {

struct ForceLimits {
  double max_N = 100;                    ///< of the vector's length; > 0, at most 1e12
  double max_slew_N_per_s = 1e6;         ///< of the change's length; > 0, finite
};

struct ForceGuardCounters {               // calls, each
  std::int64_t clamped = 0;
  std::int64_t slewed = 0;
  std::int64_t non_finite = 0;
};

class ForceGuard {
 public:
  explicit ForceGuard(ForceLimits limits);
  /// The force to send at `now`, which must not decrease. Before the first call the device renders nothing, so the slew
  /// starts from zero force at the first call's time, and the first call sends zero whatever is wanted. A force schedule is
  /// empty (zero) at its first tick, so no strategy sees this; from the second tick on the slew has a whole period.
  glm::dvec3 pass(RealTime now, const glm::dvec3& wanted_N);
  const ForceGuardCounters& counters() const { return counters_; }

 private:
  glm::dvec3 clamped(const glm::dvec3& wanted_N);

  ForceLimits limits_;
  ForceGuardCounters counters_;
  glm::dvec3 last_N_{0};
  RealTime last_at_;
  bool started_ = false;
};

}  // namespace evenstep
