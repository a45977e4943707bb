#pragma once
/// The step limit that holds in every configuration.
///
/// A spring's energy k (|d| - L)^2 / 2 has the Hessian k (n n' + (1 - L/|d|)(I - n n')), at most k I however long it is. So
/// the whole Hessian is at most the scalar Laplacian of the spring graph, for each axis: u' H u <= sum k (u_i - u_j)^2. (A
/// compressed spring's negative eigenvalue is buckling, which is physics, not an unstable step.) The damping matrix of axial
/// dampers c n n' is bounded in the same way, a coupling's spring or a probe's penalty by its stiffness on every particle it
/// holds or can touch. With lambda the largest eigenvalue of M^-1 (bound of H) and gamma that of M^-1 (bound of the
/// damping), the mass-proportional damping d included, symplectic Euler is
///   (I - h C / 2) (u_n+1 - 2 u_n + u_n-1) + h C (u_n+1 - u_n-1) / 2 + h^2 K u_n = 0,    M = 1,
/// which dissipates the energy of I - h C / 2 - h^2 K / 4 as long as that is positive:
///   h^2 lambda + 2 h gamma < 4,    without damping h < 2 / sqrt(lambda).
/// Velocity Verlet takes the same path with the velocity half a step aside, so it has the same limit. The classical Runge-
/// Kutta method is stable for |h s| <= 2.6 in the left half plane (2 sqrt(2) on the imaginary axis), s = gamma/2 +
/// sqrt(gamma^2/4 + lambda) at most. Implicit methods have no limit.
///
/// lambda is found cube by cube: a spring along an axis belongs to four cubes of eight sites, one across a face to two, a
/// particle to eight, so K = sum K_e and M = sum M_e with these shares, and x' K x <= sum lambda_e x' M_e x <= max lambda_e
/// x' M x. A full cube of one material gives 24 k/m, the corner of the lattice's symbol 6 - 2 (cx + cy + cz) + 12 - 4 (cx cy
/// + cy cz + cz cx) at (-1, -1, 1), which a large block nearly reaches; a chain 4 k/m. Gershgorin's row sums, without the
/// particles that do not move, are less where few do (k/m for one particle on one spring): the lesser counts.
///
/// It is a limit for steps of one length. Where the length changes, a mode grows if the product of its step matrices does:
/// of two alternating lengths, without damping, if w^2 (h1 + h2)^2 - (w^2 h1 h2)^2 > 4. A longer pattern can resonate with
/// a mode that makes a whole number of half turns in it while each step is far below that mode's own limit (one long step
/// and 14 of half its length: 1.4 times per round at 0.58 of 2 / w; Skeel, Variable step size destabilizes the
/// Stoermer/leapfrog/Verlet method, BIT 33, 1993). So where the step follows the run time (Scene::variable_step), a step
/// above the limit is one way to diverge, not the only one.
///
/// The rest-state limit, with the springs' Hessian k n n' at rest (12 k/m for one material), is printed beside it and is not
/// safe: a stretched block diverges below it.

#include <cstdint>

#include "evenstep/sim/scene.h"

namespace evenstep {

struct StepLimit {
  double lambda_per_s2 = 0;             ///< configuration-free bound on the largest eigenvalue of M^-1 K
  double damping_per_s = 0;             ///< bound on the largest eigenvalue of M^-1 C
  double rest_state_lambda_per_s2 = 0;  ///< at rest, untouched: not safe
  double step_s = 0;                    ///< largest stable step of the scene's method; infinite for implicit ones
  double rest_state_step_s = 0;
  /// Site x + nx (y + ny z) of the first mobile particle with most stiffness per mass; -1: none.
  std::int64_t particle = -1;
};
inline constexpr double kStepSafety = 0.9;

/// What the method makes of these bounds: the largest stable h; infinite for implicit methods.
double largest_stable_step_s(Method method, double lambda_per_s2, double damping_per_s);
/// The factor on all stiffness (of springs and tools) that would make `step_s` the limit, masses and damping unchanged:
/// above 1 there is room. 0 where damping alone is too much; infinite for implicit methods.
double stiffness_margin(Method method, const StepLimit& limit, double step_s);

/// Throws SolverError for a scene that make_solver would refuse.
StepLimit step_limit(const TissueScene& scene);
/// Substeps per step for `substeps = "auto"`: least n with step / n <= kStepSafety * limit. Throws SolverError above
/// kMaxSubsteps.
int auto_substeps(const TissueScene& scene, Rate step_rate);

}  // namespace evenstep
