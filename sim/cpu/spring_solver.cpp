// F = -k x: memoryless and exact, in double.
#include "cpu/cpu_solvers.h"
#include "src/environments.h"

namespace evenstep::internal {
namespace {

class SpringSolver final : public EnvironmentSolver {
 public:
  explicit SpringSolver(const Scene& scene)
      : EnvironmentSolver(scene), stiffness_N_per_m_(std::get<SpringScene>(scene.body).stiffness_N_per_m) {
    check_stiffness(stiffness_N_per_m_, "the spring");
  }
  /// The length of the step does not matter: the spring has no memory.
  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double>) override {
    check_positions(positions_m);
    ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool)
      response.force_N[tool] = positions_m[tool] * -stiffness_N_per_m_;
    for (std::size_t tool = 0; tool < contacts_.size(); ++tool)
      contacts_[tool] = {
          .touching = true, .point_m = positions_m[tool], .stiffness_N_per_m = glm::dmat3(stiffness_N_per_m_)};
    return response;
  }

 private:
  double stiffness_N_per_m_;
};

}  // namespace

std::unique_ptr<Solver> make_spring_solver(const Scene& scene) { return std::make_unique<SpringSolver>(scene); }

}  // namespace evenstep::internal
