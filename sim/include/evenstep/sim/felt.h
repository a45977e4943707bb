#pragma once
/// What a tool feels of a scene without running it: known in closed form for a spring, a wall and a mode, not for a tissue.

#include <glm/vec3.hpp>
#include <optional>

#include "evenstep/sim/scene.h"

namespace evenstep {

/// Stiffness that a tool at rest feels; none for a tissue.
std::optional<double> felt_stiffness_N_per_m(const Scene& scene);
/// Energy that the scene stores while a tool rests at `position_m`. Only a spring and a wall have no state of their own, so only
/// for them does the position alone determine it; none otherwise.
std::optional<double> stored_energy_J(const Scene& scene, const glm::dvec3& position_m);

}  // namespace evenstep
