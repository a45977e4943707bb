#pragma once
/// How a device tick computes its force from the record that is scheduled for it. A force that comes late by the latency L
/// is smooth but soft: the hand has moved on, and the largest stable stiffness falls to b / L (stiffness_laws.h). If the
/// solver also reports the stiffness of the contact and the position of the tool, the tick can answer the hand's position
/// now.
///
///   force   F = F_c: the scheduled force (the paper). Needs no class.
///   local   F = F_a + alpha K (x_c - x): the solver's tangent at the tool's current position (multirate local model).
///           Two hands in one tissue: + alpha C (x'_c - x'), where x' is the other hand and C how this force follows it.
///   smith   F = F_c + G[x](t) - G[x](t_read): one mass-spring mode in place of the spring K (Smith predictor).
///
/// x is the newest sample. The rest is interpolated in the schedule, all fields with the same weight. A contact that only
/// pushes never pulls: F = 0 where n . F < 0. All three are pure functions of recorded data; they use no libm, and a tick
/// does not allocate.

#include <array>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "evenstep/device/symmetric.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// What a step leaves for the device lane.
struct ContactRecord {
  glm::dvec3 force_N{0};        ///< F_c, on the hand
  glm::dvec3 tool_m{0};         ///< x_c, the position that the step was given
  Symmetric stiffness_N_per_m;  ///< K in f(x + d) = f(x) - K d; out of contact that of the next contact
  glm::dvec3 normal{0};         ///< n, unit, out of the surface towards the tool; zero if there is no surface
  double gap_m = 0;             ///< from the tool to the surface, < 0 inside it
  bool unilateral = false;      ///< it pushes and never pulls
  RealTime read_at;             ///< when the hand was at tool_m
  /// C in f(x + d, x' + d') = f(x, x') - K d - C d', where x' is the other tool of the same tissue; 0 if nothing couples
  /// them
  glm::dmat3 coupling_N_per_m{0};
  glm::dvec3 other_m{0};              ///< x'_c, the other tool's position that the step was given
  Symmetric other_stiffness_N_per_m;  ///< K', the other tool's own stiffness
  glm::dvec3 other_force_N{0};        ///< F'_c, on the other hand
};

/// The same contact made softer: with K = sum of k_i v_i v_i', every k_i above `most_N_per_m` is reduced to that value, and
/// the part of F_c along v_i in the same proportion. So K <- S K, C <- S C and F_c <- S F_c with S = sum of min(1, most /
/// k_i) v_i v_i': a spring becomes a spring of the allowed stiffness, a surface stays where it is, and the record stays
/// consistent. (Clamping K alone would be worse than nothing: the stiffness missing in K would act late, and that makes the
/// loop unstable.) `most_N_per_m` > 0. A record whose k_i are all below it, or that is not finite, is returned unchanged,
/// bit for bit.
struct Softened {
  ContactRecord record;
  double stiffest_N_per_m = 0;  ///< the largest k_i of the original record
};
Softened softened(const ContactRecord& record, double most_N_per_m);
/// The same for two hands that play their coupling: M = [K C; C' K'] = sum of k_i v_i v_i' over six axes, and M <- S M and
/// (F_c, F'_c) <- S (F_c, F'_c) with S = sum of min(1, most / k_i) v_i v_i'. The record gets its own three rows. If both
/// hands do this with the same limit, what they play together is one matrix M whose eigenvalues are all at most
/// `most_N_per_m`; a cap on each hand's own K alone leaves M up to twice as stiff, one hand against the other. The
/// eigenvalues are what counts because two hands of mass m and damping b that move along v_i are one hand of mass m and
/// damping b at a spring k_i, so the law of one spring limits each k_i. (Where the hands differ, the limit of the lesser one
/// holds for both.)
Softened softened_together(const ContactRecord& record, double most_N_per_m);

/// Which part of the stiffness answers the hand at once. The force itself is always played whole; along what is left out
/// here it comes late by the latency.
enum class StiffnessPart {
  all,
  /// Of a contact that only pushes, K <- (n' K n) n n'. The stiffness to the side is that of the few particles that are
  /// touched now. A tool that slides on has left them before the record arrives (docs/forces/stiffness.md).
  normal,
  axes  ///< the diagonal; only for comparison
};
ContactRecord with_part(const ContactRecord& record, StiffnessPart part);

/// The record as the affine law F(x) = force_N + K (tool_m - x), which can be interpolated, even between contact and no
/// contact.
struct AffineContact {
  glm::dvec3 force_N{0};  ///< F_a
  glm::dvec3 tool_m{0};
  Symmetric stiffness_N_per_m;
  glm::dvec3 outward{0};  ///< n of a contact that only pushes, otherwise zero; interpolated, not quite unit
  RealTime read_at;
  glm::dmat3 coupling_N_per_m{0};
  glm::dvec3 other_m{0};
};
/// In contact F_a = F_c. Out of contact the force is 0, but the law is continued to the tool's side of the surface:
/// F_a = -gap K n. This force would pull, so it is not played, but it makes the next contact begin exactly at the surface.
/// If `knows_gap` is false (the solver does not compute distances), there is no law out of contact: K = 0.
AffineContact affine_contact(const ContactRecord& record, bool knows_gap);
/// Interpolates all fields with the same weight; ForceSchedule calls it. The mean of two positive semidefinite K is positive
/// semidefinite as well.
AffineContact lerp(const AffineContact& a, const AffineContact& b, double w);

/// A record stays in use after its time if no newer one comes, because its law still answers the hand. But from kFadeAfter
/// past its emission time on, force and stiffness fade together, linearly, to zero within kFadeFor: a simulation that no
/// longer steps must not hold the hand.
inline constexpr Duration kFadeAfter{100'000'000};
inline constexpr Duration kFadeFor{50'000'000};
/// The factor, falling from 1 to 0. `age` is the time since the newest emission time; it is 0 or negative while that is
/// still to come.
double fade(Duration age);

/// F = fade (F_a + alpha [K (x_c - x) + C (x'_c - x')]).
class LocalRenderer {
 public:
  /// alpha in (0, 4]: 1 is the tangent itself; stiffness_laws.h explains why a little more is better and less much worse.
  explicit LocalRenderer(double alpha) : alpha_(alpha) {}
  /// `other_m`: x', the newest sample of the other hand; nullptr: the coupling is not played.
  glm::dvec3 force_N(const AffineContact& scheduled, Duration age, const glm::dvec3& hand_m,
                     const glm::dvec3* other_m = nullptr) const;

 private:
  double alpha_;
};

/// A mass M between two springs, along each axis: the tool pulls on it through K_c, the ground through K_t, and c damps it.
///   M q'' = K_c (x - q) - K_t q - c q',   G[x] = -K_c (x - q)
/// Statically G[x] = -K_c K_t / (K_c + K_t) x.
struct SpringMode {
  double contact_N_per_m = 0;    ///< K_c > 0
  double ground_N_per_m = 0;     ///< K_t > 0
  double mass_kg = 0;            ///< M > 0
  double damping_N_s_per_m = 0;  ///< c >= 0
};

/// Computes G from the samples as they come, and remembers its past values. Between two samples x moves in a straight line.
/// It is integrated in steps of at most 25 us and a twentieth of the mode's time sqrt(M / (K_c + K_t)),
/// v <- v + h a(q, x), q <- q + h v, which is Verlet's path with a velocity half a step behind: second order except for the
/// damping. It starts at rest under the first sample, and does so again after a pause longer than kFadeAfter.
class SmithRenderer {
 public:
  /// `memory`: how far back t_read may lie; `period`: the time from tick to tick. An older read gets the oldest value kept.
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
