#include "evenstep/sim/felt.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <variant>

namespace evenstep {

std::optional<double> felt_stiffness_N_per_m(const Scene& scene) {
  return std::visit(
      [](const auto& body) -> std::optional<double> {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, TissueScene>) return std::nullopt;
        else return body.stiffness_N_per_m;
      },
      scene.body);
}

std::optional<double> stored_energy_J(const Scene& scene, const glm::dvec3& x) {
  const auto dot = [](const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  if (const auto* spring = std::get_if<SpringScene>(&scene.body)) return spring->stiffness_N_per_m * dot(x, x) / 2;
  const auto* wall = std::get_if<WallScene>(&scene.body);
  if (wall == nullptr) return std::nullopt;
  const double depth_m = std::max(0.0, wall->surface_m - dot(wall->normal, x) / std::sqrt(dot(wall->normal, wall->normal)));
  const double harder = wall->hardening_m > 0 ? 2 * depth_m / (3 * wall->hardening_m) : 0;
  return wall->stiffness_N_per_m * depth_m * depth_m / 2 * (1 + harder);
}

}  // namespace evenstep
