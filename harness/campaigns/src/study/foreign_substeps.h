#pragma once
/// A solver of the program on shorter steps than the scene's: [study] step_sizes of a foreign scene.

#include "evenstep/sim/scene.h"

namespace evenstep::internal {

/// Each step of the scene is `substeps` steps of the solver, during which the tools move linearly, as in the substeps of
/// evenstep's own solvers; the forces are those after the last one. The solver is made for the shorter step.
ForeignScene with_substeps(const ForeignScene& scene, int substeps);

}  // namespace evenstep::internal
