#include "cpu/method.h"

#include <fmt/format.h>

#include <algorithm>

namespace evenstep::internal {
namespace {

const char* name_of(Method method) {
  switch (method) {
    case Method::rk4:
      return "RK4";
    case Method::implicit_euler:
      return "implicit Euler";
    case Method::implicit_midpoint:
      return "implicit midpoint";
    default:
      return "vertex block descent";
  }
}

void check_features(const TissueScene& scene) {
  const auto refuse = [&](bool asked_for, const char* feature) {
    if (!asked_for) return;
    throw SolverError(SolverFault::bad_scene, fmt::format("{} cannot simulate {}", name_of(scene.method), feature),
                      "method = \"symplectic_euler\", or a scene without it");
  };
  refuse(!scene.regions.empty(), "material regions");
  refuse(scene.axial_damping_N_s_per_m > 0, "axial damping");
  refuse(scene.gravity_m_per_s2 != glm::dvec3(0), "gravity");
  const auto is_grab = [](const ToolCoupling& tool) { return tool.kind == CouplingKind::grab; };
  refuse(!std::all_of(scene.tools.begin(), scene.tools.end(), is_grab), "tools other than grabs");
}

}  // namespace

template <class Real>
std::unique_ptr<CellMethod<Real>> make_method(const MethodCells<Real>& cells, double substep_s) {
  switch (cells.scene.method) {
    case Method::symplectic_euler:
    case Method::velocity_verlet:
      return nullptr;
    case Method::rk4:
      check_features(cells.scene);
      return make_runge_kutta(cells, substep_s);
    case Method::implicit_euler:
    case Method::implicit_midpoint:
      check_features(cells.scene);
      return make_implicit(cells, substep_s);
    case Method::vertex_block_descent:
      check_features(cells.scene);
      return make_vertex_block_descent(cells, substep_s);
  }
  return nullptr;
}
template std::unique_ptr<CellMethod<float>> make_method(const MethodCells<float>&, double);
template std::unique_ptr<CellMethod<double>> make_method(const MethodCells<double>&, double);

double method_arrays(Method method) {
  switch (method) {
    case Method::rk4:
      return 15;
    case Method::implicit_euler:
    case Method::implicit_midpoint:
      return 17;
    case Method::vertex_block_descent:
      return 8;
    default:
      return 0;
  }
}

}  // namespace evenstep::internal
