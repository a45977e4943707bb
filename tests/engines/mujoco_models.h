#pragma once
// The scenes of MuJoCo as it reads them (MJCF).

#include <optional>

#include "evenstep/sim/foreign_solver.h"
#include "options.h"

namespace engines {

struct MujocoScene {
  std::string xml;
  glm::dvec3 tool_rest_m{0};  ///< where a hand at the origin has the tool
  std::optional<Particles> particles;
};
/// Throws SolverError for options that there are not.
MujocoScene mujoco_scene(const evenstep::SolverRequest& request);

}  // namespace engines
