#pragma once
#include <memory>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {
std::unique_ptr<Solver> make_opencl_tissue(const Scene& scene, const SolverOptions& options);
}  // namespace evenstep::internal
