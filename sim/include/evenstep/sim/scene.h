#pragma once
/// What is simulated. Only what a scene names exists in the run.

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <variant>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

inline constexpr int kMaxTools = 2;
inline constexpr int kMaxSubsteps = 100'000;  ///< per step: more is a mistake in the units of mass or stiffness

/// F = -k x on every tool: memoryless, so constant velocity must give a linear force. The force reported is what the
/// hand feels: -k x.
struct SpringScene {
  double stiffness_N_per_m = 200;
};

/// Which particles a tool holds: those within `radius_m` of `center_m` (block coordinates, m; the origin is the block's
/// minimum corner), without the fixed ones. They move rigidly with the tool's displacement from its first sample (kinematic
/// grab), in a straight line over the substeps. Grabs must not share a particle.
struct Grab {
  glm::dvec3 center_m{0};
  double radius_m = 0;
};

/// The paper's tissue: particles on a cubic lattice, each joined by springs to its 18 neighbours (6 faces, 12 edges), rest
/// lengths `spacing` and sqrt(2) `spacing`. Cut to exactly `particle_count` by leaving out the last lattice sites in
/// x-fastest order (of the top layer, the one farthest from the fixed one).
struct TissueScene {
  std::array<int, 3> lattice{27, 27, 28};
  std::int64_t particle_count = 20'270;  ///< <= product of lattice
  double spacing_m = 5e-3;
  double particle_mass_kg = 1.25e-4;
  double stiffness_N_per_m = 50;
  double damping_per_s = 0;  ///< mass-proportional: v <- (1 - h damping) v + h f / m in a substep of h
  bool fixed_bottom = true;  ///< layer z = 0 does not move
  int substeps = 0;          ///< per step; 0 = "auto": least that meets the configuration-free bound
  std::vector<Grab> grabs;   ///< one per tool
};

struct Scene {
  std::variant<SpringScene, TissueScene> body;
  Rate step_rate{450, 1};  ///< 1 / step_size: simulated seconds per step, constant (the paper's premise)
  int tool_count = 1;
  bool needs_state_digest = true;  ///< somebody calls Solver::state_digest
  bool needs_energy = false;       ///< an expectation asks for it
  bool allow_unstable = false;     ///< [scene] allow_unstable
  bool variable_step = false;      ///< somebody gives Solver::step lengths of their own
};

enum class SolverKind { cpu_float, cpu_double, opencl };

}  // namespace evenstep
