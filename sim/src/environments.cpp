#include "src/environments.h"

#include <cmath>
#include <string>

namespace evenstep::internal {

void check_stiffness(double stiffness_N_per_m, const char* of) {
  if (!std::isfinite(stiffness_N_per_m) || stiffness_N_per_m <= 0)
    throw SolverError(SolverFault::bad_scene, std::string(of) + "'s stiffness is not positive", "a stiffness in N/m");
}

glm::dvec3 unit_normal(const glm::dvec3& normal) {
  const double length = std::sqrt(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
  if (!std::isfinite(length) || !(length > 0))
    throw SolverError(SolverFault::bad_scene, "the surface has no normal",
                      "a direction out of the surface, such as (1, 0, 0)");
  return normal / length;
}

void check_positions(std::span<const glm::dvec3> positions_m) {
  for (const glm::dvec3& x : positions_m) {
    if (std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z)) continue;
    throw SolverError(SolverFault::bad_input, "a tool position is not finite",
                      "check the device's reports or the recorded motion");
  }
}

glm::dmat3 along(const glm::dvec3& n, double stiffness_N_per_m) {
  glm::dmat3 matrix(0);
  for (int column = 0; column < 3; ++column) matrix[column] = n * (n[column] * stiffness_N_per_m);
  return matrix;
}

std::size_t contact_count(const Scene& scene) {
  return scene.local_model == LocalModel::none ? 0 : static_cast<std::size_t>(scene.tool_count);
}

}  // namespace evenstep::internal
