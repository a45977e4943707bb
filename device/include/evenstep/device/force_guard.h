#pragma once
/// The force guard always stands between the schedule and the device. It limits the force (a force that is too large is
/// shortened, not set to zero), limits its change per second, and fades the force out while something is wrong. It is not a
/// safety device.
///
///   target = authority * (gain * wanted, shortened to max_N); 0 if wanted is not finite
///   sent   = last sent + (target - last sent), shortened to max_slew_N_per_s * (now - time of the last call)
///
/// The authority starts at 0. From the first force on it rises to 1 within `ramp_up` while all is well. During a cut it
/// falls to 0 within `ramp_down`, and after the cut it rises again. Reasons for a cut: the hand moves too fast, the force or
/// the hand's position is not renewed, the device says that its motors are off. While the device is away (unplugged) nothing
/// is sent, and it renders nothing: authority and last force are 0 at once, so the force rises from 0 even after the
/// shortest absence. A force that nothing limits, at gain 1 and authority 1, passes bit for bit. A limited force keeps its
/// direction, and rounding may make it longer than the limit by a few 1e-16 of it. A call at the same instant as the last
/// one cannot change the force.

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

/// What cuts a force off. With the defaults nothing does, and the full force is rendered at once.
struct CutLimits {
  double gain = 1;              ///< (0, 1]
  Duration ramp_up, ramp_down;  ///< time in which the authority goes from 0 to 1, and back; 0: at once
  double max_speed_m_per_s = std::numeric_limits<double>::infinity();  ///< > 0; the cut ends below half of it
  Duration stale_force = kNeverStale;  ///< cut this long after the newest force of the schedule was due
  Duration stale_hand = kNeverStale;   ///< cut this long after the last fresh sample
};

struct ForceLimits {
  double max_N = 100;             ///< limit on the length of the force; > 0, at most 1e12
  double max_slew_N_per_s = 1e6;  ///< limit on the length of its change; > 0, finite
  CutLimits cut;
};

struct ForceGuardCounters {  // the first three count calls
  std::int64_t clamped = 0;
  std::int64_t slewed = 0;
  std::int64_t non_finite = 0;
  // Cuts that began while the device was driven. Each is counted once, for the first of its reasons in this order:
  std::int64_t cuts_device = 0;  ///< DeviceSample::drivable was false
  std::int64_t cuts_stale_hand = 0;
  std::int64_t cuts_stale_force = 0;
  std::int64_t cuts_speed = 0;
};

/// Which limits made the force of the last call differ from `gain * wanted`.
struct GuardLimited {
  bool clamped = false;
  bool slewed = false;
  bool cut = false;  ///< the authority was below 1: a cut, or the way up after one or at the start
  bool non_finite = false;
};

/// Whether the guard lets the force through. armed: all of it. ramping: a growing share. waiting: no force has come yet, so
/// there is none to cut. cut_...: a shrinking share or none, for the first of its reasons in the order of
/// ForceGuardCounters.
enum class GuardState : std::uint8_t { armed, ramping, waiting, cut_device, cut_stale_hand, cut_stale_force, cut_speed };

/// What the guard is told in a tick besides the wanted force.
struct GuardedTick {
  DeviceSample sample;
  std::optional<RealTime> force_due;  ///< when the newest force of the schedule was due; empty before the first
};

class ForceGuard {
 public:
  explicit ForceGuard(ForceLimits limits);
  /// The force to send at `now`, which must not decrease. Before the first call the device renders nothing. So the slew
  /// limit starts from zero force at the time of the first call, and the first call sends zero whatever is wanted. This does
  /// not affect any strategy, because a force schedule is still empty (zero) at its first tick; from the second tick on the
  /// slew has a whole period.
  glm::dvec3 pass(RealTime now, const glm::dvec3& wanted_N, const GuardedTick& tick);
  /// The part of these springs that a device may render by itself; call it after pass(). Their stiffness is multiplied by
  /// gain * authority, and each of n axes is limited to authority * max_N / sqrt(n), so that all of them together obey
  /// max_N. The slew is not limited, because it is that of the hand. There is no spring where stiffness or center is not
  /// finite.
  DeviceSpring share(const DeviceSpring& wanted) const;
  /// The authority at the last call, [0, 1].
  double authority() const { return authority_; }
  /// As of the last call; before the first it is waiting.
  GuardState state() const;
  const ForceGuardCounters& counters() const { return counters_; }
  /// The limits at the last call.
  const GuardLimited& limited() const { return limited_; }

 private:
  glm::dvec3 clamped(const glm::dvec3& wanted_N);
  void follow_hand(const DeviceSample& sample);
  GuardState reason_to_cut(RealTime now, const GuardedTick& tick) const;
  void move_authority(RealTime now, const GuardedTick& tick);

  struct Position {
    RealTime at;
    glm::dvec3 m;
  };
  ForceLimits limits_;
  ForceGuardCounters counters_;
  GuardLimited limited_;
  glm::dvec3 last_N_{0};
  RealTime last_at_;
  bool started_ = false;
  double authority_ = 0;
  GuardState reason_ = GuardState::cut_stale_force;  // armed: there is none to cut
  bool too_fast_ = false;
  bool any_force_ = false;           // the schedule has had one
  std::array<Position, 16> hand_{};  // the last fresh samples, a ring
  std::size_t fresh_samples_ = 0;
};

}  // namespace evenstep
