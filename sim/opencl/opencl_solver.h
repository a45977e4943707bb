#pragma once
#include <memory>

#include "evenstep/sim/solver.h"
#include "src/features.h"

namespace evenstep::internal {
std::unique_ptr<Solver> make_opencl_tissue(const Scene& scene, const SceneFeatures& features, const SolverOptions& options);
}  // namespace evenstep::internal
