#pragma once
/// What a device tick makes of the record that is scheduled for it. A force that comes L late is smooth but soft: the hand
/// has moved on, and the largest stable stiffness falls to b / L (stiffness_laws.h). A solver that says how stiff the contact
/// is, and where the tool was, lets the tick answer the hand as it is now.
///
///   force   F = F_c: the scheduled force (the paper). Needs no class.
///   local   F = F_a + alpha K (x_c - x): the solver's tangent at the tool's position now (multirate local model).
///   smith   F = F_c + G[x](t) - G[x](t_read): one mass-spring mode in place of the spring K (Smith predictor).
///
/// x the newest sample, the rest interpolated in the schedule, every field with the same weight. A contact that only pushes
/// never pulls: F = 0 where n . F < 0. All three are pure functions of what was recorded; no libm, no allocation in a tick.

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "evenstep/device/symmetric.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// What one step leaves for the device lane.
struct ContactRecord {
  glm::dvec3 force_N{0};           ///< F_c, on the hand
  glm::dvec3 tool_m{0};            ///< x_c, the position that the step was given
  Symmetric stiffness_N_per_m;     ///< K in f(x + d) = f(x) - K d; out of contact that of the contact to come
  glm::dvec3 normal{0};            ///< n, unit, out of the surface towards the tool; zero where there is no side
  double gap_m = 0;                ///< from the tool to the surface, < 0 inside it
  bool unilateral = false;         ///< pushes and never pulls
  RealTime read_at;                ///< when the hand was at tool_m
};

/// The same contact, softer: of K = sum of k_i v_i v_i' every k_i above `most_N_per_m` becomes that, and what of F_c is along
/// v_i becomes smaller in proportion. K <- S K and F_c <- S F_c with S = sum of min(1, most / k_i) v_i v_i', so a spring is a
/// spring of the stiffness allowed, a surface stays where it is, and the record stays consistent. (To clamp K alone would be
/// worse than nothing: what is missing in K comes late, which is what makes the loop unstable.) `most_N_per_m` > 0; below it a
/// record is returned as it is, bit for bit, and so is one that is not finite.
struct Softened {
  ContactRecord record;
  double stiffest_N_per_m = 0;     ///< the largest k_i of the record that was given
};
Softened softened(const ContactRecord& record, double most_N_per_m);

/// The record as the affine law F(x) = force_N + K (tool_m - x), which interpolates: between contact and no contact too.
struct AffineContact {
  glm::dvec3 force_N{0};           ///< F_a
  glm::dvec3 tool_m{0};
  Symmetric stiffness_N_per_m;
  glm::dvec3 outward{0};           ///< n of a contact that only pushes, otherwise zero; between two records not quite unit
  RealTime read_at;
};
/// F_a = F_c in contact. Out of contact the force is 0, but the law goes on on the surface's far side: F_a = -gap K n, which
/// pulls and so is not played, and is where the contact to come begins. With `knows_gap` false (a solver that has no
/// distances) there is no law out of contact: K = 0.
AffineContact affine_contact(const ContactRecord& record, bool knows_gap);
/// Every field with the same weight; found by ForceSchedule. Of positive semidefinite K the mix is so too.
AffineContact lerp(const AffineContact& a, const AffineContact& b, double w);

/// A record that outlives its time is kept: its law still answers the hand. From kFadeAfter past its emission time on, force
/// and stiffness fade together, linearly, to nothing within kFadeFor: whoever does not step any more must not hold the hand.
inline constexpr Duration kFadeAfter{100'000'000};
inline constexpr Duration kFadeFor{50'000'000};
/// 1, falling to 0; `age`: time since the newest emission time, negative or 0 while there is one to come.
double fade(Duration age);

/// F = fade (F_a + alpha K (x_c - x)).
class LocalRenderer {
 public:
  /// alpha in (0, 4]: 1 is the tangent itself, stiffness_laws.h says why a little more is better and less is much worse.
  explicit LocalRenderer(double alpha) : alpha_(alpha) {}
  glm::dvec3 force_N(const AffineContact& scheduled, Duration age, const glm::dvec3& hand_m) const;

 private:
  double alpha_;
};

/// A mass M between two springs, along each axis: the tool pulls on it by K_c, the ground by K_t, and c resists.
///   M q'' = K_c (x - q) - K_t q - c q',   G[x] = -K_c (x - q)
/// Statically G[x] = -K_c K_t / (K_c + K_t) x.
struct SpringMode {
  double contact_N_per_m = 0;      ///< K_c > 0
  double ground_N_per_m = 0;       ///< K_t > 0
  double mass_kg = 0;              ///< M > 0
  double damping_N_s_per_m = 0;    ///< c >= 0
};

/// G of the samples as they come, with a memory of what it gave. Between two samples x goes in a straight line. Steps of
/// at most 25 us and a twentieth of the mode's time sqrt(M / (K_c + K_t)), v <- v + h a(q, x), q <- q + h v, which is
/// Verlet's path with the velocity half a step behind: second order but for the damping. It starts at rest under the first
/// sample, and again after a pause longer than kFadeAfter.
class SmithRenderer {
 public:
  /// `memory`: how far back t_read may lie, at `period` per tick. A read older than that gives the oldest kept.
  SmithRenderer(const SpringMode& mode, Duration memory, Duration period);
  /// One tick; `now` must increase. F = fade (F_c + G(now) - G(read_at)).
  glm::dvec3 force_N(const AffineContact& scheduled, Duration age, RealTime now, const glm::dvec3& hand_m);

 private:
  struct Output {
    RealTime at;
    glm::dvec3 force_N{0};
  };
  void rest_at(const glm::dvec3& hand_m);
  void advance(Duration by, const glm::dvec3& hand_m);
  glm::dvec3 output_at(RealTime at) const;
  const Output& back(std::size_t ticks) const;

  SpringMode mode_;
  double longest_step_s_;
  std::vector<Output> outputs_;  // a ring of the last `kept_` ticks
  std::size_t kept_ = 0, next_ = 0;
  glm::dvec3 hand_m_{0}, mass_m_{0}, velocity_m_per_s_{0};
};

}  // namespace evenstep
