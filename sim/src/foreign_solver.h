#pragma once
/// Makes a solver that the program has registered usable like any other solver.

#include <memory>

#include "evenstep/sim/foreign_solver.h"

namespace evenstep::internal {

/// Throws SolverError, which names the solver, if the solver cannot be made or lacks what the scene needs.
std::unique_ptr<Solver> make_foreign_solver(const ForeignScene& foreign, const Scene& scene);

}  // namespace evenstep::internal
