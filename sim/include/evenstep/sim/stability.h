#pragma once
/// The largest stable step: a limit that holds in every configuration of the tissue.
///
/// A spring's energy k (|d| - L)^2 / 2 has the Hessian k (n n' + (1 - L/|d|)(I - n n')), which is at most k I however long
/// the spring is. So for each axis the whole Hessian is at most the scalar Laplacian of the spring graph:
///   u' H u <= sum k (u_i - u_j)^2.
/// (A compressed spring's negative eigenvalue is buckling, which is physics and not an unstable step.) The damping matrix of
/// axial dampers c n n' is bounded in the same way; the bound of a coupling's spring or a probe's penalty is its stiffness
/// on every particle that it holds or can touch. Let lambda be the largest eigenvalue of M^-1 (bound of H), and gamma that
/// of M^-1 (bound of the damping), which includes the drag d of the lightest particle that moves. Then symplectic Euler is
///   (I - h C / 2) (u_n+1 - 2 u_n + u_n-1) + h C (u_n+1 - u_n-1) / 2 + h^2 K u_n = 0,    M = 1,
/// which dissipates the energy of I - h C / 2 - h^2 K / 4 as long as that is positive:
///   h^2 lambda + 2 h gamma < 4,    without damping h < 2 / sqrt(lambda).
/// Velocity Verlet takes the same path with a velocity that is half a step apart, so it has the same limit. The classical
/// Runge-Kutta method is stable for |h s| <= 2.6 in the left half plane (2 sqrt(2) on the imaginary axis), where |s| is at
/// most gamma/2 + sqrt(gamma^2/4 + lambda). Implicit methods have no limit.
///
/// lambda is found cube by cube. Each cube of eight sites gets a quarter of a spring along an axis (it belongs to four
/// cubes), half of a spring across a face (two cubes) and an eighth of a particle (eight cubes). With these shares
///   K = sum K_e,   M = sum M_e,   and   x' K x <= sum lambda_e x' M_e x <= max lambda_e x' M x.
/// A full cube of one material gives 24 k/m, the value of the lattice's symbol
///   6 - 2 (cx + cy + cz) + 12 - 4 (cx cy + cy cz + cz cx)
/// at its corner (-1, -1, 1), which a large block nearly reaches; a chain gives 4 k/m. Gershgorin's row sums, without the
/// particles that do not move, are smaller if few particles move (k/m for one particle on one spring). The smaller of the
/// two bounds is used.
///
/// This limit is for steps of equal length. If the length changes, a mode grows if the product of its step matrices does:
/// with two alternating lengths and without damping, if w^2 (h1 + h2)^2 - (w^2 h1 h2)^2 > 4. A longer pattern can resonate
/// with a mode that makes a whole number of half turns in it, even if each step is far below that mode's own limit (one
/// long step and 14 of half its length: it grows by 1.4 per round at 0.58 of 2 / w; Skeel, Variable step size destabilizes
/// the Stoermer/leapfrog/Verlet method, BIT 33, 1993). So if the step follows the run time (Scene::variable_step), a step
/// above the limit is one way to diverge, but not the only one.
///
/// The rest-state limit, with the springs' Hessian k n n' at rest (12 k/m for one material) and that of couplings, is given
/// as well, but it is not safe: a stretched block diverges at steps below it, and so may one that a probe touches.

#include <cstdint>
#include <string>

#include "evenstep/sim/scene.h"

namespace evenstep {

struct StepLimit {
  double lambda_per_s2 = 0;             ///< configuration-free bound on the largest eigenvalue of M^-1 K
  double damping_per_s = 0;             ///< bound on the largest eigenvalue of M^-1 C
  double rest_state_lambda_per_s2 = 0;  ///< the same for the untouched state of rest: not a safe bound
  double step_s = 0;                    ///< largest stable step of the scene's method; infinite for implicit ones
  double rest_state_step_s = 0;         ///< what rest_state_lambda_per_s2 gives: not safe
  /// Site x + nx (y + ny z) of the first mobile particle with the most stiffness per mass; -1: none.
  std::int64_t particle = -1;
};
inline constexpr double kStepSafety = 0.9;

/// The largest stable step h of the method with these bounds; infinite for implicit methods.
double largest_stable_step_s(Method method, double lambda_per_s2, double damping_per_s);
/// The factor on all stiffnesses (of springs and tools) for which `step_s` would be exactly the limit, with masses and
/// damping unchanged: above 1 there is room. 0 if the damping alone is too much; infinite for implicit methods.
double stiffness_margin(Method method, const StepLimit& limit, double step_s);

/// What sets the limit, for messages: "particle 7 at site (1, 2, 0) sets them", or, if no moving particle has a spring, what
/// does instead.
std::string what_sets(const TissueScene& scene, const StepLimit& limit);

/// Throws SolverError for a scene that make_solver would refuse.
StepLimit step_limit(const TissueScene& scene);
/// Substeps per step for `substeps = "auto"`: the least n with step / n <= kStepSafety * limit. Throws SolverError if that
/// is more than kMaxSubsteps.
int auto_substeps(const TissueScene& scene, Rate step_rate);

}  // namespace evenstep
