#pragma once
// Scenes and motions shared by the tests of the solvers. Motions are polynomials of the step number, because nothing that
// is compared bit by bit may depend on libm.
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "evenstep/sim/solver.h"

namespace evenstep::test {

using Positions = std::array<glm::dvec3, kMaxTools>;

inline Scene scene_of(TissueScene tissue, double step_s, bool energy = false) {
  Scene scene{std::move(tissue)};
  scene.step_rate = {1'000'000'000, std::llround(step_s * 1e9)};
  scene.tool_count = static_cast<int>(std::get<TissueScene>(scene.body).tools.size());
  scene.needs_energy = energy;
  return scene;
}

/// Two particles with a spring along x. The tool holds the particle at the origin. A spring on a line is exactly linear.
inline TissueScene spring_pair() {
  TissueScene tissue;
  tissue.lattice = {2, 2, 2};
  tissue.particle_count = 2;
  tissue.spacing_m = 0.01;
  tissue.particle_mass_kg = 1e-3;
  tissue.stiffness_N_per_m = 40;
  tissue.fixed = FixedFaces::none();
  tissue.substeps = 1;
  tissue.tools = {{glm::dvec3(0), 1e-3}};
  return tissue;
}

/// 8 x 7 x 9 sites with a ragged top layer, two tools near the top.
inline TissueScene small_block() {
  TissueScene tissue;
  tissue.lattice = {8, 7, 9};
  tissue.particle_count = 8 * 7 * 9 - 19;
  tissue.spacing_m = 5e-3;
  tissue.particle_mass_kg = 1e-4;
  tissue.stiffness_N_per_m = 20;
  tissue.tools = {{glm::dvec3(1, 3, 7) * 5e-3, 6e-3}, {glm::dvec3(6, 3, 7) * 5e-3, 8e-3}};
  return tissue;
}

/// The positions of two tools on cubic paths of up to 20 mm in 200 steps, with a rest, and a jump of 3 mm at step 120.
inline Positions wandering_tools(int n) {
  const double t = n / 200.0, jump_m = n >= 120 ? 3e-3 : 0;
  return {glm::dvec3(0.02 * t * t * (3 - 2 * t), -0.01 * t * (1 - t), 0.015 * t + jump_m),
          glm::dvec3(0.3 - 0.01 * t * t * t, 0.1 + 0.02 * t * (1 - t), n < 20 ? 0.0 : -0.012 * (t - 0.1))};
}

inline ToolResponse step(Solver& solver, int tools, const Positions& positions_m) {
  return solver.step(std::span(positions_m.data(), static_cast<std::size_t>(tools)));
}

/// Compares bit by bit: NaN equals itself, 0.0 and -0.0 differ.
inline bool same_bits(const ToolResponse& a, const ToolResponse& b) {
  return std::memcmp(&a.force_N, &b.force_N, sizeof a.force_N) == 0;
}
inline bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

inline double norm(const glm::dvec3& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

inline const std::array kEverySolver{SolverKind::cpu_float, SolverKind::cpu_double, SolverKind::opencl};

}  // namespace evenstep::test
