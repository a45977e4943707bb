#pragma once
// The scenes for MuJoCo, in the format that it reads (MJCF).

#include <optional>

#include "evenstep/sim/foreign_solver.h"
#include "options.h"

namespace engines {

struct MujocoScene {
  std::string xml;
  glm::dvec3 tool_rest_m{0};  ///< where the tool is if the hand is at the origin
  std::optional<Particles> particles;
};
/// Throws SolverError for options that do not exist.
MujocoScene mujoco_scene(const evenstep::SolverRequest& request);

}  // namespace engines
