#pragma once
/// The scene of a trial as a solver of the program gets it: in its options, as `particles`.
///
///   "particles": { "mass": kg, "stiffness": N/m, "rest": [[x, y, z], ...], "displacement": [[x, y, z], ...],
///                  "fixed": [0, ...], "springs": [[0, 1], ...] }
/// Lengths in m. `rest` and `displacement` have an entry per particle, `fixed` the numbers of those that never move. Each
/// spring is linear, has this stiffness, and is as long as its particles are apart at rest. All start at rest.

#include <memory>
#include <string>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {

/// The options, a JSON object, with the scene in them. It has no regions, damping, gravity or tools.
std::string options_with_particles(const std::string& options, const TissueScene& scene);

/// Throws SolverError if the solver cannot be made, or does not show its particles.
std::unique_ptr<Solver> make_case_solver(const ForeignScene& foreign, const Scene& scene);

}  // namespace evenstep::internal
