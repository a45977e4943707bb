#pragma once
/// What a tool can meet besides a tissue, in closed form or nearly so. Computed in double whatever the solver kind.

#include <memory>
#include <optional>
#include <span>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {

std::unique_ptr<Solver> make_wall_solver(const Scene& scene);
std::unique_ptr<Solver> make_mode_solver(const Scene& scene);

// Shared by them; each throws SolverError.

void check_stiffness(double stiffness_N_per_m, const char* of);
/// Of length 1.
glm::dvec3 unit_normal(const glm::dvec3& normal);
void check_positions(std::span<const glm::dvec3> positions_m);

/// n n' k: a spring along n.
glm::dmat3 along(const glm::dvec3& n, double stiffness_N_per_m);
/// Contacts exist only where somebody reads them.
std::size_t contact_count(const Scene& scene);

}  // namespace evenstep::internal
