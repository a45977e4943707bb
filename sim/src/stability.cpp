#include "evenstep/sim/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/sim/solver.h"
#include "src/lattice.h"

namespace evenstep {
namespace {

constexpr double kLatticeSymbol = 24, kLatticeSymbolAtRest = 12;  // the header derives them

/// Largest h with h^2 lambda + 2 h d <= 4, in the form that does not cancel where damping dominates.
double largest_step_s(double lambda_per_s2, double damping_per_s) {
  return 4 / (std::sqrt(damping_per_s * damping_per_s + 4 * lambda_per_s2) + damping_per_s);
}

}  // namespace

StepLimit step_limit(const TissueScene& scene) {
  internal::check_tissue(scene, static_cast<int>(scene.grabs.size()));
  const internal::Lattice lattice(scene);
  const double k_per_m = scene.stiffness_N_per_m / scene.particle_mass_kg;
  // A single particle has no spring, and any step will do: one spring's worth keeps the limit finite.
  const double gershgorin = 2.0 * static_cast<double>(std::max<std::int64_t>(1, lattice.most_springs_of_a_particle));
  StepLimit limit;
  limit.lambda_per_s2 = std::min(kLatticeSymbol, gershgorin) * k_per_m;
  limit.step_s = largest_step_s(limit.lambda_per_s2, scene.damping_per_s);
  limit.rest_state_step_s = largest_step_s(std::min(kLatticeSymbolAtRest, gershgorin) * k_per_m, scene.damping_per_s);
  limit.particle = lattice.particle_with_most_springs;
  return limit;
}

int auto_substeps(const TissueScene& scene, Rate step_rate) {
  const double step_s = period_s(step_rate), longest_s = kStepSafety * step_limit(scene).step_s;
  const double needed = std::ceil(step_s / longest_s);
  if (!(needed <= kMaxSubsteps)) {
    throw SolverError(SolverFault::unstable_step,
                      fmt::format("a step of {:g} ms needs {:g} substeps of {:g} ms", step_s * 1e3, needed, longest_s * 1e3),
                      fmt::format("at most {}: less stiffness or damping, more mass, or shorter steps", kMaxSubsteps));
  }
  return std::max(1, static_cast<int>(needed));
}

}  // namespace evenstep
