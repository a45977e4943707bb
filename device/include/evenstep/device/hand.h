#pragma once
/// A simulated hand that feels forces: a mass that follows its intended path p(t) through a spring, held back by the
/// friction of the device and by the force that the device renders. Unlike a programmed motion, it can show a loop that
/// becomes unstable and shakes.
///
///   (m + m_a) x'' = F + push - b x' - k (x - p) - b_a (x' - p') - k_a (x - p)
///
/// m, b: mass of the moving part of the device and its friction; k: spring that pulls it towards the path; m_a, b_a, k_a: an
/// arm that grips the device rigidly and pulls it towards the path too (the worst case for stability is no arm); F: the
/// force of the device, constant between two changes.
///
/// Integrated by velocity Verlet with the damping taken implicitly, on a fixed grid of 25 us from t = 0 that is cut where F
/// changes:
///   w = v + h/2 a(x, v),   x <- x + h w,   v <- (w + h/2 a(x, 0)) / (1 + h (b + b_a) / (2 (m + m_a)))
/// Second order: a free mass without friction under a piecewise constant force is exact, and the frequency of an oscillation
/// is too high by (w h)^2 / 24 of itself, 0.04 % for the fastest hand that is allowed. (Semi-implicit Euler would act half a
/// grid step early, which changes the stiffness limit of an even 1 kHz loop by 2.5 %.) The position between two grid points
/// is that of a step that ends there. No libm is used, so the bits are the same on every machine.

#include <cstdint>
#include <deque>
#include <optional>
#include <stdexcept>
#include <string>

#include <glm/vec3.hpp>

#include "evenstep/device/motion.h"
#include "evenstep/time/time.h"

namespace evenstep {

struct HandSpec {
  double mass_kg = 0.2;          ///< of the moving part of the device; > 0
  double damping_N_s_per_m = 1;  ///< of the device; >= 0
  double stiffness_N_per_m = 0;  ///< towards the path; >= 0
  struct Arm {
    double mass_kg = 0;
    double damping_N_s_per_m = 0;  ///< acts on the velocity relative to that of the path
    double stiffness_N_per_m = 0;  ///< towards the path
  };
  std::optional<Arm> arm;
  glm::dvec3 push_N{0};            ///< a constant force in addition to all springs
  glm::dvec3 offset_m{0};          ///< from the path at t = 0
  glm::dvec3 velocity_m_per_s{0};  ///< at t = 0

  double total_mass_kg() const { return mass_kg + (arm ? arm->mass_kg : 0); }
  double total_damping_N_s_per_m() const { return damping_N_s_per_m + (arm ? arm->damping_N_s_per_m : 0); }
  double total_stiffness_N_per_m() const { return stiffness_N_per_m + (arm ? arm->stiffness_N_per_m : 0); }
};

inline constexpr Duration kHandStep{25'000};
/// sqrt(stiffness / mass) and damping / mass of the whole hand must not exceed this, a tenth of 1 / kHandStep.
inline constexpr double kFastestHand_per_s = 4000;
inline constexpr double kHandReach_m = 2;  ///< about the most that a report in int32 nanometres can hold

/// The hand left +-2 m along an axis, or its position is not a number.
class HandDiverged : public std::runtime_error {
 public:
  HandDiverged(const std::string& what, RealTime when) : std::runtime_error(what), at(when) {}
  RealTime at;
};

class Hand {
 public:
  /// Another `grid` than kHandStep is only for tests of the integration error.
  Hand(HandSpec spec, ProgrammedMotion path, Duration grid = kHandStep);
  /// Sets F from the instant `from` on, which must not be before any instant passed to feel() or position_m() so far.
  void feel(RealTime from, const glm::dvec3& force_N);
  /// The position at an instant. Instants must not decrease; before t = 0 it is the initial one. Throws HandDiverged.
  glm::dvec3 position_m(RealTime at);

 private:
  struct Phase {
    glm::dvec3 position_m, velocity_m_per_s;
    glm::dvec3 path_m;  // p(t), kept so that the next step need not compute it again
  };
  /// The phase after one step from at_ to `end`, which is at most a grid step later.
  Phase after(RealTime end) const;
  RealTime step_end() const;

  HandSpec spec_;
  ProgrammedMotion path_;
  Duration grid_;
  RealTime at_;  // the time of phase_
  Phase phase_;
  glm::dvec3 force_N_{0};
  struct Change {
    RealTime from;
    glm::dvec3 force_N;
  };
  std::deque<Change> changes_;  // future changes, in order
};

}  // namespace evenstep
