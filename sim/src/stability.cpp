#include "evenstep/sim/stability.h"

#include <algorithm>
#include <cmath>

#include "src/lattice.h"

namespace evenstep {
namespace {

/// Largest h with h^2 lambda + 2 h d < 4 (symplectic Euler with mass-proportional damping d, Jury's conditions).
double largest_step_s(double lambda_per_s2, double damping_per_s) {
  if (lambda_per_s2 <= 0) return damping_per_s > 0 ? 2 / damping_per_s : INFINITY;
  return (std::sqrt(damping_per_s * damping_per_s + 4 * lambda_per_s2) - damping_per_s) / lambda_per_s2;
}

}  // namespace

StepLimit step_limit(const TissueScene& scene) {
  const internal::Lattice lattice(scene);
  const double k_per_m = scene.stiffness_N_per_m / scene.particle_mass_kg;
  // The quadratic form of the scalar Laplacian is the sum over springs of (u_i - u_j)^2; a cut block only leaves springs
  // out of the infinite lattice, and fixed or grabbed particles only rows, so its largest eigenvalue is at most the symbol's
  // maximum: sum over neighbours of (1 - cos theta r), which is multilinear in the three cosines and largest (24) at
  // (-1, -1, 1). Gershgorin's row bound, twice the springs of the busiest particle, is smaller on very thin blocks.
  const double laplacian = std::min(24.0, 2.0 * static_cast<double>(lattice.most_springs_of_a_particle));
  StepLimit limit;
  limit.lambda_per_s2 = laplacian * k_per_m;
  limit.step_s = largest_step_s(limit.lambda_per_s2, scene.damping_per_s);
  limit.rest_state_step_s = largest_step_s(std::min(12.0, laplacian) * k_per_m, scene.damping_per_s);
  limit.particle = lattice.particle_with_most_springs;
  return limit;
}

int auto_substeps(const TissueScene& scene, Rate step_rate) {
  const double needed = period_s(step_rate) / (kStepSafety * step_limit(scene).step_s);
  return std::max(1, static_cast<int>(std::ceil(needed)));
}

}  // namespace evenstep
