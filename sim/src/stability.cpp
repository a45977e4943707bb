#include "evenstep/sim/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <tuple>

#include "evenstep/sim/solver.h"
#include "src/tissue/lattice.h"
#include "src/tissue/materials.h"
#include "src/tissue/rest_hessian.h"
#include "src/tissue/symmetric_eigenvalue.h"

namespace evenstep {
namespace {

using internal::Lattice;

constexpr double kForEver = std::numeric_limits<double>::infinity();

/// What a particle contributes to the cubes it belongs to.
struct Particle {
  bool active = false, mobile = false;
  double stiffness_N_per_m = 0, mass_kg = 1;
  double held_N_per_m = 0, held_N_s_per_m = 0;  // its share of a coupling's spring and damper
  auto operator<=>(const Particle&) const = default;
};

/// The particle of every cell, as an index into the few kinds of particles that occur.
struct Particles {
  Particles(const TissueScene& scene, const Lattice& lattice);
  const Particle& operator[](std::size_t cell) const { return kinds[kind[cell]]; }
  std::vector<Particle> kinds{Particle{}};
  std::vector<std::uint8_t> kind;
};

Particles::Particles(const TissueScene& scene, const Lattice& lattice) : kind(lattice.cells, 0) {
  const internal::Materials materials(scene, lattice);
  std::vector<std::uint8_t> holder(lattice.cells, 0);  // tool + 1
  for (std::size_t tool = 0; tool < lattice.held.size(); ++tool)
    for (const std::uint32_t cell : lattice.held[tool]) holder[cell] = static_cast<std::uint8_t>(tool + 1);
  std::map<Particle, std::uint8_t> seen;
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::size_t cell = lattice.cell(site);
    Particle particle{true, lattice.mobile[cell] != 0, materials.stiffness_N_per_m(cell), materials.mass_kg(cell)};
    if (holder[cell] > 0 && particle.mobile) {
      const ToolCoupling& tool = scene.tools[holder[cell] - 1u];
      const auto shared_by = static_cast<double>(lattice.held[holder[cell] - 1u].size());
      particle.held_N_per_m = tool.stiffness_N_per_m / shared_by;
      particle.held_N_s_per_m = tool.damping_N_s_per_m / shared_by;
    }
    const auto [entry, is_new] = seen.emplace(particle, static_cast<std::uint8_t>(kinds.size()));
    if (is_new) kinds.push_back(particle);  // at most kMaxRegions + 1 materials, fixed, free or held by either tool
    kind[cell] = entry->second;
  }
}

/// The corners of a cube, x-fastest; and the largest eigenvalues of its share of the system.
using Corners = std::array<Particle, 8>;
struct CubeBounds {
  double lambda = 0, damping = 0;
};

CubeBounds bounds_of(const Corners& corners, double axial_damping_N_s_per_m) {
  internal::SymmetricMatrix<8> stiffness, damping;
  const auto add = [&](std::size_t i, std::size_t j, double share) {
    const double k = share * internal::spring_stiffness(corners[i].stiffness_N_per_m, corners[j].stiffness_N_per_m);
    const double c = share * axial_damping_N_s_per_m;
    for (const std::size_t row : {i, j}) {
      for (const std::size_t column : {i, j}) {
        if (!corners[row].mobile || !corners[column].mobile) continue;
        const double sign = row == column ? 1 : -1;
        const double mass_kg = std::sqrt(corners[row].mass_kg * corners[column].mass_kg) / 8;  // a particle has eight cubes
        stiffness(row, column) += sign * k / mass_kg;
        damping(row, column) += sign * c / mass_kg;
      }
    }
  };
  for (std::size_t i = 0; i < 8; ++i) {
    if (!corners[i].active) continue;
    for (std::size_t j = i + 1; j < 8; ++j) {
      if (!corners[j].active) continue;
      const int axes = __builtin_popcount(static_cast<unsigned>(i ^ j));
      if (axes == 1) add(i, j, 0.25);
      if (axes == 2) add(i, j, 0.5);
    }
  }
  for (std::size_t i = 0; i < 8; ++i) {
    if (!corners[i].mobile) continue;
    stiffness(i, i) += corners[i].held_N_per_m / corners[i].mass_kg;
    damping(i, i) += corners[i].held_N_s_per_m / corners[i].mass_kg;
  }
  return {internal::largest_eigenvalue(stiffness), internal::largest_eigenvalue(damping)};
}

CubeBounds largest_cube_bounds(const TissueScene& scene, const Lattice& lattice, const Particles& particles) {
  const auto [nx, ny, nz] = scene.lattice;
  const std::ptrdiff_t px = nx + 1, layer = px * (ny + 1);
  CubeBounds most;
  std::map<std::uint64_t, CubeBounds> known;
  std::uint64_t last = 0;
  // Starts one plane, row and column before the first site; a cell in the padding has no particle (0).
  const auto begin = static_cast<std::ptrdiff_t>(lattice.first) - layer - px - 1;
  const auto end = static_cast<std::ptrdiff_t>(lattice.first) + layer * nz;
  for (std::ptrdiff_t cell = begin; cell < end; ++cell) {
    std::uint64_t key = 0;
    std::array<std::uint8_t, 8> kinds{};
    for (std::size_t corner = 0; corner < 8; ++corner) {
      const std::ptrdiff_t at = cell + static_cast<std::ptrdiff_t>(corner & 1u) +
                                static_cast<std::ptrdiff_t>((corner >> 1) & 1u) * px +
                                static_cast<std::ptrdiff_t>(corner >> 2) * layer;
      if (at >= 0 && at < static_cast<std::ptrdiff_t>(lattice.cells))
        kinds[corner] = particles.kind[static_cast<std::size_t>(at)];
      key = key << 8 | kinds[corner];
    }
    if (key == last) continue;  // nearly always; a key of 0 means a cube without particles
    last = key;
    const auto [entry, is_new] = known.try_emplace(key);
    if (!is_new) continue;
    Corners corners;
    for (std::size_t corner = 0; corner < 8; ++corner) corners[corner] = particles.kinds[kinds[corner]];
    entry->second = bounds_of(corners, scene.axial_damping_N_s_per_m);
    most.lambda = std::max(most.lambda, entry->second.lambda);
    most.damping = std::max(most.damping, entry->second.damping);
  }
  return most;
}

struct RowBounds {
  double lambda = 0, damping = 0;
  double stiffest = 0;  // largest of the diagonal alone
  std::int64_t particle = -1;
};

/// Gershgorin's row sums of M^-1 K and M^-1 C over the mobile particles.
RowBounds largest_rows(const TissueScene& scene, const Lattice& lattice, const Particles& particles) {
  RowBounds most;
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::size_t cell = lattice.cell(site);
    const Particle& particle = particles[cell];
    if (!particle.mobile) continue;
    double diagonal = particle.held_N_per_m, others = 0, dampers = 0, other_dampers = 0;
    for (const std::ptrdiff_t offset : lattice.offset) {
      const Particle& other = particles[cell + static_cast<std::size_t>(offset)];
      if (!other.active) continue;
      const double k = internal::spring_stiffness(particle.stiffness_N_per_m, other.stiffness_N_per_m);
      diagonal += k;
      dampers += scene.axial_damping_N_s_per_m;
      if (!other.mobile) continue;
      others += k;
      other_dampers += scene.axial_damping_N_s_per_m;
    }
    const double rows_damping = (dampers + particle.held_N_s_per_m + other_dampers) / particle.mass_kg;
    most.lambda = std::max(most.lambda, (diagonal + others) / particle.mass_kg);
    most.damping = std::max(most.damping, rows_damping);
    if (diagonal / particle.mass_kg <= most.stiffest) continue;
    most.stiffest = diagonal / particle.mass_kg;
    most.particle = site;
  }
  return most;
}

/// The mass of the lightest particle that moves; infinite if none does.
double lightest_kg(const Particles& particles) {
  double least_kg = kForEver;
  for (const Particle& particle : particles.kinds)
    if (particle.mobile) least_kg = std::min(least_kg, particle.mass_kg);
  return least_kg;
}

/// The sum of the stiffnesses of all probes.
double probes_N_per_m(const TissueScene& scene) {
  double stiffness_N_per_m = 0;
  for (const ToolCoupling& tool : scene.tools)
    stiffness_N_per_m += tool.kind == CouplingKind::probe ? tool.stiffness_N_per_m : 0;
  return stiffness_N_per_m;
}

/// The largest eigenvalue of M^-1 K at rest, where a spring resists only along itself. For one material without couplings it
/// is 12 k/m, the maximum of the lattice's symbol, at (pi, pi, 0). Otherwise it comes from a power iteration, which gives a
/// value too small by a fraction of a percent.
double rest_state_lambda(const TissueScene& scene, const Lattice& lattice, const Particles& particles) {
  const bool coupled = std::any_of(scene.tools.begin(), scene.tools.end(),
                                   [](const ToolCoupling& tool) { return tool.kind == CouplingKind::spring; });
  if (scene.regions.empty() && !coupled) return 12 * scene.stiffness_N_per_m / scene.particle_mass_kg;
  const internal::RestHessian hessian(scene, lattice);
  std::vector<glm::dvec3> x(lattice.cells, glm::dvec3(0)), y = x, z = x;
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const std::size_t cell = lattice.cell(site);
    const auto component = [&](std::uint64_t n) {
      return static_cast<double>((static_cast<std::uint64_t>(site) * 3 + n) * 2654435761u % 1000) / 500 - 1;
    };
    if (particles[cell].mobile) x[cell] = {component(0), component(1), component(2)};
  }
  double lambda = 0;
  constexpr int kRounds = 100;
  for (int round = 0; round < kRounds; ++round) {
    double xx = 0, xy = 0, yy = 0;
    for (const std::size_t cell : hessian.mobile()) z[cell] = x[cell] / std::sqrt(particles[cell].mass_kg);
    hessian.apply(z, y);
    for (const std::size_t cell : hessian.mobile()) {
      y[cell] /= std::sqrt(particles[cell].mass_kg);
      xx += glm::dot(x[cell], x[cell]);
      xy += glm::dot(x[cell], y[cell]);
      yy += glm::dot(y[cell], y[cell]);
    }
    if (yy <= 0) return 0;
    lambda = xy / xx;
    const double scale = 1 / std::sqrt(yy);
    for (std::size_t cell = 0; cell < lattice.cells; ++cell) x[cell] = y[cell] * scale;
  }
  return lambda;
}

}  // namespace

double largest_stable_step_s(Method method, double lambda_per_s2, double damping_per_s) {
  // Both formulas are written in the form that does not cancel digits when damping dominates.
  switch (method) {
    case Method::symplectic_euler:
    case Method::velocity_verlet:
      return 4 / (std::sqrt(damping_per_s * damping_per_s + 4 * lambda_per_s2) + damping_per_s);
    case Method::rk4: {
      const double largest_per_s = damping_per_s / 2 + std::sqrt(damping_per_s * damping_per_s / 4 + lambda_per_s2);
      return (damping_per_s > 0 ? 2.6 : std::sqrt(8.0)) / largest_per_s;
    }
    default:
      return kForEver;
  }
}

double stiffness_margin(Method method, const StepLimit& limit, double step_s) {
  const double gamma = limit.damping_per_s;
  double lambda_per_s2 = kForEver;  // the largest for which this step would be stable
  if (method == Method::symplectic_euler || method == Method::velocity_verlet)
    lambda_per_s2 = (4 - 2 * step_s * gamma) / (step_s * step_s);
  if (method == Method::rk4) {
    const double largest_per_s = (gamma > 0 ? 2.6 : std::sqrt(8.0)) / step_s;
    lambda_per_s2 = largest_per_s * (largest_per_s - gamma);
  }
  return std::max(0.0, lambda_per_s2) / limit.lambda_per_s2;
}

StepLimit step_limit(const TissueScene& scene) {
  internal::check_tissue(scene, static_cast<int>(scene.tools.size()));
  const Lattice lattice(scene);
  const Particles particles(scene, lattice);
  const CubeBounds cubes = largest_cube_bounds(scene, lattice, particles);
  const RowBounds rows = largest_rows(scene, lattice, particles);
  StepLimit limit;
  const double lightest = lightest_kg(particles);
  // Any particle may be touched by all probes.
  limit.lambda_per_s2 = std::min(cubes.lambda, rows.lambda) + probes_N_per_m(scene) * (1 / lightest);
  // If no mobile particle has a spring, any step is stable; the stiffness of one spring keeps the limit finite.
  if (limit.lambda_per_s2 <= 0) limit.lambda_per_s2 = scene.stiffness_N_per_m / scene.particle_mass_kg;
  limit.rest_state_lambda_per_s2 = std::min(limit.lambda_per_s2, rest_state_lambda(scene, lattice, particles));
  if (limit.rest_state_lambda_per_s2 <= 0) limit.rest_state_lambda_per_s2 = limit.lambda_per_s2;
  limit.damping_per_s = scene.damping_per_s * (scene.particle_mass_kg / lightest) + std::min(cubes.damping, rows.damping);
  limit.step_s = largest_stable_step_s(scene.method, limit.lambda_per_s2, limit.damping_per_s);
  limit.rest_state_step_s = largest_stable_step_s(scene.method, limit.rest_state_lambda_per_s2, limit.damping_per_s);
  limit.particle = rows.particle;
  return limit;
}

std::string what_sets(const TissueScene& scene, const StepLimit& limit) {
  const auto [nx, ny, nz] = scene.lattice;
  if (limit.particle >= 0)
    return fmt::format("particle {} at site ({}, {}, {}) sets them", limit.particle, limit.particle % nx,
                       limit.particle / nx % ny, limit.particle / nx / ny);
  if (probes_N_per_m(scene) > 0) return "no particle that moves has a spring; what the probes may touch sets them";
  return "no particle that moves has a spring; they are those of one particle on one spring";
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
