#pragma once
#include <memory>

#include "evenstep/sim/solver.h"
#include "src/features.h"

namespace evenstep::internal {
std::unique_ptr<Solver> make_spring_solver(const Scene& scene);
std::unique_ptr<Solver> make_cpu_tissue_float(const Scene& scene, const SceneFeatures& features);
std::unique_ptr<Solver> make_cpu_tissue_double(const Scene& scene, const SceneFeatures& features);
}  // namespace evenstep::internal
