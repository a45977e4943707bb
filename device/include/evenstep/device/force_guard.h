#pragma once
/// Always between the schedule and the device: limits the force (never zeroes a large one), its change per second, and how much
/// of it is rendered at all while something is not as it should be. Not a safety device.
///
///   target = authority * (gain * wanted, shortened to max_N); 0 where wanted is not finite
///   sent   = last sent + (target - last sent), shortened to max_slew_N_per_s * (now - time of the last call)
///
/// The authority starts at 0, rises to 1 in `ramp_up` from the first force on while all is well, and falls to 0 in `ramp_down` during a cut: a hand that
/// moves too fast, a force or a hand that is not renewed, a device that says that its motors are off. After a cut it rises again.
/// A force that nothing limits, at gain 1 and authority 1, passes bit for bit; a limited one keeps its direction and may be longer
/// than the limit by rounding (a few 1e-16 of it). A call at the instant of the last one may not change the force.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include <glm/vec3.hpp>

#include "evenstep/device/haptic_device.h"
#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr Duration kNeverStale{std::numeric_limits<std::int64_t>::max()};

/// What cuts a force off. The defaults never do, and render all of it at once.
struct CutLimits {
  double gain = 1;                       ///< (0, 1]
  Duration ramp_up, ramp_down;           ///< of the authority between 0 and 1; 0: at once
  double max_speed_m_per_s = std::numeric_limits<double>::infinity();  ///< > 0; the cut ends below half of it
  Duration stale_force = kNeverStale;    ///< since the newest force of the schedule was due
  Duration stale_hand = kNeverStale;     ///< since the last fresh sample
};

struct ForceLimits {
  double max_N = 100;                    ///< of the vector's length; > 0, at most 1e12
  double max_slew_N_per_s = 1e6;         ///< of the change's length; > 0, finite
  CutLimits cut;
};

struct ForceGuardCounters {               // calls, each
  std::int64_t clamped = 0;
  std::int64_t slewed = 0;
  std::int64_t non_finite = 0;
  // Cuts that began while the device was driven, each counted for the first of its reasons in this order:
  std::int64_t cuts_device = 0;          ///< DeviceSample::drivable was false
  std::int64_t cuts_stale_hand = 0;
  std::int64_t cuts_stale_force = 0;
  std::int64_t cuts_speed = 0;
};

/// What a tick knows besides the force it wants.
struct GuardedTick {
  DeviceSample sample;
  std::optional<RealTime> force_due;     ///< when the newest force of the schedule was due; none: before the first
};

class ForceGuard {
 public:
  explicit ForceGuard(ForceLimits limits);
  /// The force to send at `now`, which must not decrease. Before the first call the device renders nothing, so the slew
  /// starts from zero force at the first call's time, and the first call sends zero whatever is wanted. A force schedule is
  /// empty (zero) at its first tick, so no strategy sees this; from the second tick on the slew has a whole period.
  glm::dvec3 pass(RealTime now, const glm::dvec3& wanted_N, const GuardedTick& tick);
  /// What of these springs a device may render by itself, after pass(): gain * authority as stiff, and along each of n axes
  /// at most authority * max_N / sqrt(n), so that all of them together obey max_N. Their slew is not limited: it is that of
  /// the hand. Where stiffness or center is not finite there is no spring.
  DeviceSpring share(const DeviceSpring& wanted) const;
  /// Share of the force that was rendered at the last call, [0, 1].
  double authority() const { return authority_; }
  const ForceGuardCounters& counters() const { return counters_; }

 private:
  glm::dvec3 clamped(const glm::dvec3& wanted_N);
  void follow_hand(const DeviceSample& sample);
  std::int64_t* reason_to_cut(RealTime now, const GuardedTick& tick);
  void move_authority(RealTime now, const GuardedTick& tick);

  struct Position {
    RealTime at;
    glm::dvec3 m;
  };
  ForceLimits limits_;
  ForceGuardCounters counters_;
  glm::dvec3 last_N_{0};
  RealTime last_at_;
  bool started_ = false;
  double authority_ = 0;
  bool cut_ = false, too_fast_ = false;
  std::array<Position, 16> hand_{};      // the last fresh samples, a ring
  std::size_t fresh_samples_ = 0;
};

}  // namespace evenstep
