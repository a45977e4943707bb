// F = n k (p + p^2 / l) at the depth p, and 0 outside: memoryless and exact, in double.
#include <algorithm>
#include <cmath>

#include "src/environments.h"

namespace evenstep::internal {
namespace {

class WallSolver final : public EnvironmentSolver {
 public:
  explicit WallSolver(const Scene& scene)
      : EnvironmentSolver(scene), wall_(std::get<WallScene>(scene.body)), normal_(unit_normal(wall_.normal)) {
    check_stiffness(wall_.stiffness_N_per_m, "the wall");
    if (!std::isfinite(wall_.surface_m))
      throw SolverError(SolverFault::bad_scene, "the wall's surface is nowhere", "a length along its normal");
    if (std::isnan(wall_.hardening_m) || wall_.hardening_m < 0)
      throw SolverError(SolverFault::bad_scene, "the wall's hardening length is negative", "a length, or 0 for none");
  }

  /// The length of the step does not matter: the wall has no memory.
  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double>) override {
    check_positions(positions_m);
    ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) {
      const glm::dvec3& x = positions_m[tool];
      const double gap_m = normal_.x * x.x + normal_.y * x.y + normal_.z * x.z - wall_.surface_m;
      const double depth_m = std::max(0.0, -gap_m);
      const double deep = wall_.hardening_m > 0 ? depth_m / wall_.hardening_m : 0;
      response.force_N[tool] = normal_ * (wall_.stiffness_N_per_m * depth_m * (1 + deep));
      if (tool >= contacts_.size()) continue;
      // Outside the wall, the stiffness is what the tool will meet when it touches.
      contacts_[tool] = {gap_m <= 0, true, x, normal_, gap_m, along(normal_, wall_.stiffness_N_per_m * (1 + 2 * deep))};
    }
    return response;
  }

 private:
  WallScene wall_;
  glm::dvec3 normal_;
};

}  // namespace

std::unique_ptr<Solver> make_wall_solver(const Scene& scene) { return std::make_unique<WallSolver>(scene); }

}  // namespace evenstep::internal
