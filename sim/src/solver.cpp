#include "evenstep/sim/solver.h"

#include "cpu/cpu_solvers.h"
#include "opencl/opencl_solver.h"
#include "src/environments.h"

namespace evenstep {

std::unique_ptr<Solver> make_solver(SolverKind kind, const Scene& scene, const SolverOptions& options) {
  if (scene.tool_count < 0 || scene.tool_count > kMaxTools) {
    throw SolverError(SolverFault::bad_scene, std::to_string(scene.tool_count) + " tools",
                      "at most " + std::to_string(kMaxTools));
  }
  // These scenes are a few operations in double: they need no device, and have the same bits with every kind of solver.
  if (std::holds_alternative<SpringScene>(scene.body)) return internal::make_spring_solver(scene);
  if (std::holds_alternative<WallScene>(scene.body)) return internal::make_wall_solver(scene);
  if (std::holds_alternative<ModeScene>(scene.body)) return internal::make_mode_solver(scene);
  const internal::SceneFeatures features = internal::features_of(scene);
  switch (kind) {
    case SolverKind::cpu_float:
      return internal::make_cpu_tissue_float(scene, features);
    case SolverKind::cpu_double:
      return internal::make_cpu_tissue_double(scene, features);
    case SolverKind::opencl:
      return internal::make_opencl_tissue(scene, features, options);
  }
  return nullptr;
}

}  // namespace evenstep
