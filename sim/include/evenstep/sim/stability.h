#pragma once
/// The step limit that holds in every configuration. A spring's Hessian is at most k I, so a step is stable if
///   step <= 2 / sqrt(lambda),   lambda = the largest eigenvalue of the mass-scaled scalar Laplacian of the spring graph
/// (24 k/m on the full 18-neighbour lattice). The rest-state limit (12 k/m) is not safe: a stretched block diverges below
/// it. With mass-proportional damping d the explicit limit of symplectic Euler shrinks to
///   step^2 lambda + 2 step d < 4  (docs/numerics.md).

#include <cstdint>

#include "evenstep/sim/scene.h"

namespace evenstep {

struct StepLimit {
  double lambda_per_s2 = 0;          ///< configuration-free bound on the largest eigenvalue
  double step_s = 0;                 ///< largest stable step
  double rest_state_step_s = 0;      ///< from 12 k/m: printed beside it, not safe
  std::int64_t particle = -1;        ///< lattice index of the particle with the largest row sum
};
inline constexpr double kStepSafety = 0.9;

/// lambda by Gershgorin's row sum 2 * (number of springs) k / m of the particle with most springs (an upper bound that is
/// reached by the full lattice: 36 k/m is replaced by the lattice symbol's 24 k/m where the particle has all 18).
StepLimit step_limit(const TissueScene& scene);
/// Substeps per step for `substeps = "auto"`: least n with step / n <= kStepSafety * limit.
int auto_substeps(const TissueScene& scene, Rate step_rate);

}  // namespace evenstep
