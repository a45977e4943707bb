#include "evenstep/sim/solver.h"

#include "cpu/cpu_solvers.h"
#include "opencl/opencl_solver.h"
#include "src/environments.h"
#include "src/foreign_solver.h"

namespace evenstep {

const char* name_of(Method method) {
  switch (method) {
    case Method::symplectic_euler:
      return "symplectic-euler";
    case Method::velocity_verlet:
      return "velocity-verlet";
    case Method::rk4:
      return "rk4";
    case Method::implicit_euler:
      return "implicit-euler";
    case Method::implicit_midpoint:
      return "implicit-midpoint";
    case Method::vertex_block_descent:
      return "vertex-block-descent";
  }
  return "";
}

const char* name_of(SolverKind solver) {
  switch (solver) {
    case SolverKind::opencl:
      return "opencl";
    case SolverKind::cpu_float:
      return "cpu";
    case SolverKind::cpu_double:
      return "cpu-double";
  }
  return "";
}

bool iterates(Method method) {
  return method == Method::implicit_euler || method == Method::implicit_midpoint || method == Method::vertex_block_descent;
}

const char* name_of(SolverFault fault) {
  switch (fault) {
    case SolverFault::unstable_step:
      return "unstable-step";
    case SolverFault::bad_input:
      return "bad-input";
    case SolverFault::unavailable:
    case SolverFault::bad_scene:
    case SolverFault::out_of_memory:
      return "solver";
  }
  return "solver";
}

namespace {

// An overload for each alternative of Scene::body. A spring, a wall and a mode take a few operations in double: they have
// no device, and every solver kind computes the same bits.

std::unique_ptr<Solver> solver_of(const SpringScene&, SolverKind, const Scene& scene, const SolverOptions&) {
  return internal::make_spring_solver(scene);
}
std::unique_ptr<Solver> solver_of(const WallScene&, SolverKind, const Scene& scene, const SolverOptions&) {
  return internal::make_wall_solver(scene);
}
std::unique_ptr<Solver> solver_of(const ModeScene&, SolverKind, const Scene& scene, const SolverOptions&) {
  return internal::make_mode_solver(scene);
}
std::unique_ptr<Solver> tissue_solver(const internal::SceneFeatures& features, SolverKind kind, const Scene& scene,
                                      const SolverOptions& options) {
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
std::unique_ptr<Solver> solver_of(const TissueScene&, SolverKind kind, const Scene& scene, const SolverOptions& options) {
  return tissue_solver(internal::features_of(scene), kind, scene, options);
}
std::unique_ptr<Solver> solver_of(const ForeignScene& foreign, SolverKind, const Scene& scene, const SolverOptions&) {
  return internal::make_foreign_solver(foreign, scene);
}

// The features that the solver of each alternative leaves out.

std::vector<std::string> left_out_of(const SpringScene&, const Scene&) {
  return {"particles", "substeps", "variable step", "state digest", "energy"};
}
std::vector<std::string> left_out_of(const WallScene&, const Scene& scene) { return left_out_of(SpringScene{}, scene); }
std::vector<std::string> left_out_of(const ModeScene&, const Scene& scene) {
  std::vector<std::string> names{"particles", "energy"};
  if (!scene.variable_step) names.emplace_back("variable step");
  if (!scene.needs_state_digest) names.emplace_back("state digest");
  return names;
}
std::vector<std::string> left_out_of(const TissueScene&, const Scene& scene) {
  return internal::left_out(internal::features_of(scene));
}
std::vector<std::string> left_out_of(const ForeignScene& foreign, const Scene& scene) {
  return internal::make_foreign_solver(foreign, scene)->info().left_out;
}

}  // namespace

std::vector<std::string> left_out(const Scene& scene) {
  return std::visit([&](const auto& body) { return left_out_of(body, scene); }, scene.body);
}

std::unique_ptr<Solver> make_solver_with(const std::string& feature, SolverKind kind, const Scene& scene,
                                         const SolverOptions& options) {
  if (!std::holds_alternative<TissueScene>(scene.body)) return nullptr;
  const auto features = internal::features_with(feature, scene);
  return features ? tissue_solver(*features, kind, scene, options) : nullptr;
}

std::unique_ptr<Solver> make_solver(SolverKind kind, const Scene& scene, const SolverOptions& options) {
  if (scene.tool_count < 0 || scene.tool_count > kMaxTools) {
    throw SolverError(SolverFault::bad_scene, std::to_string(scene.tool_count) + " tools",
                      "at most " + std::to_string(kMaxTools));
  }
  return std::visit([&](const auto& body) { return solver_of(body, kind, scene, options); }, scene.body);
}

}  // namespace evenstep
