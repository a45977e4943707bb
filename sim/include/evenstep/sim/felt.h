#pragma once
/// What a tool feels from a scene, without running it: known in closed form for a spring, a wall and a mode, not for a
/// tissue.

#include <glm/vec3.hpp>
#include <optional>

#include "evenstep/sim/scene.h"

namespace evenstep {

/// The stiffness that a tool at rest feels; empty for a tissue.
std::optional<double> felt_stiffness_N_per_m(const Scene& scene);
/// The energy that the scene stores while a tool rests at `position_m`. Only for a spring and a wall, which have no state of
/// their own, it is determined by the position alone; empty for other scenes.
std::optional<double> stored_energy_J(const Scene& scene, const glm::dvec3& position_m);

}  // namespace evenstep
