#pragma once
/// The step limit that holds in every configuration.
///
/// A spring's energy k (|d| - L)^2 / 2 has the Hessian k (n n' + (1 - L/|d|)(I - n n')), at most k I however long it is. So
/// the whole Hessian is at most k times the scalar Laplacian of the spring graph, for each axis: u' H u <= k sum (u_i -
/// u_j)^2. (A compressed spring's negative eigenvalue is buckling, which is physics, not an unstable step.) With the mass m
/// and mass-proportional damping d, symplectic Euler on the mode w^2 has the matrix ((1 - h d, -h w^2), (h (1 - h d), 1 -
/// h^2 w^2)) of determinant 1 - h d and trace 2 - h d - h^2 w^2, which is stable (Jury) if and only if
///   h^2 lambda + 2 h d < 4,    without damping h < 2 / sqrt(lambda).
///
/// lambda = 24 k/m on the 18-neighbour lattice: its symbol is the sum over neighbours r of 1 - cos(theta r)
///   = 6 - 2 (cx + cy + cz) + 12 - 4 (cx cy + cy cz + cz cx),    c = cos(theta),
/// linear in every cosine and so largest at a corner: 24 at (-1, -1, 1). A block cut from the lattice only leaves springs
/// out of sum (u_i - u_j)^2 (take u = 0 outside), and fixed or grabbed particles only restrict u, so 24 bounds them too.
/// Gershgorin's 2 x (springs of the busiest particle) is 36 on a full row, but smaller on very thin blocks: the lesser
/// counts.
///
/// It is a limit for steps of one length. Where the length changes, a mode grows if the product of its step matrices does:
/// of two alternating lengths, without damping, if w^2 (h1 + h2)^2 - (w^2 h1 h2)^2 > 4. A longer pattern can resonate with
/// a mode that makes a whole number of half turns in it while each step is far below that mode's own limit (one long step
/// and 14 of half its length: 1.4 times per round at 0.58 of 2 / w; Skeel, Variable step size destabilizes the
/// Stoermer/leapfrog/Verlet method, BIT 33, 1993). So where the step follows the run time (Scene::variable_step), a step
/// above the limit is one way to diverge, not the only one.
///
/// The rest-state limit (12 k/m) is printed beside it and is not safe: a stretched block diverges below it.

#include <cstdint>

#include "evenstep/sim/scene.h"

namespace evenstep {

struct StepLimit {
  double lambda_per_s2 = 0;      ///< configuration-free bound on the largest eigenvalue
  double step_s = 0;             ///< largest stable step
  double rest_state_step_s = 0;  ///< from 12 k/m: printed beside it, not safe
  std::int64_t particle = -1;    ///< site x + nx (y + ny z) of the first particle with most springs
};
inline constexpr double kStepSafety = 0.9;

/// Throws SolverError for a scene that make_solver would refuse.
StepLimit step_limit(const TissueScene& scene);
/// Substeps per step for `substeps = "auto"`: least n with step / n <= kStepSafety * limit. Throws SolverError above
/// kMaxSubsteps.
int auto_substeps(const TissueScene& scene, Rate step_rate);

}  // namespace evenstep
