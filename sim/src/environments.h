#pragma once
/// The scenes other than a tissue that need a solver: wall and mode, in closed form or nearly so. They are computed in
/// double whatever the kind of solver.

#include <memory>
#include <optional>
#include <span>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {

std::unique_ptr<Solver> make_wall_solver(const Scene& scene);
std::unique_ptr<Solver> make_mode_solver(const Scene& scene);

// Shared by these solvers. The checks throw SolverError.

void check_stiffness(double stiffness_N_per_m, const char* of);
/// The normal scaled to length 1; throws SolverError if it has none.
glm::dvec3 unit_normal(const glm::dvec3& normal);
void check_positions(std::span<const glm::dvec3> positions_m);

/// k n n': the stiffness of a spring along n.
glm::dmat3 along(const glm::dvec3& n, double stiffness_N_per_m);
/// The number of contacts to keep: one per tool if they will be read, otherwise none.
std::size_t contact_count(const Scene& scene);

}  // namespace evenstep::internal
