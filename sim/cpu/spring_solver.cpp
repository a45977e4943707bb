// F = -k x: memoryless and exact, in double.
#include <algorithm>
#include <cmath>

#include "cpu/cpu_solvers.h"
#include "src/environments.h"

namespace evenstep::internal {
namespace {

class SpringSolver final : public Solver {
 public:
  explicit SpringSolver(const Scene& scene)
      : stiffness_N_per_m_(std::get<SpringScene>(scene.body).stiffness_N_per_m),
        contacts_(scene.local_model == LocalModel::none ? 0 : static_cast<std::size_t>(scene.tool_count)) {
    if (!std::isfinite(stiffness_N_per_m_) || stiffness_N_per_m_ <= 0) {
      throw SolverError(SolverFault::bad_scene, "the spring's stiffness is not positive", "a stiffness in N/m");
    }
    info_.name = "cpu-double";
    info_.particles = 0;
    info_.left_out = evenstep::left_out(scene);
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
  std::span<const ToolContact> contacts() const override { return contacts_; }
  std::uint64_t state_digest() override { return 0; }
  void reset() override { std::fill(contacts_.begin(), contacts_.end(), ToolContact{}); }
  ParticleState particle_state() override { return {}; }
  SolverVerdict verdict() override { return {}; }
  const SolverInfo& info() const override { return info_; }

 private:
  double stiffness_N_per_m_;
  std::vector<ToolContact> contacts_;
  SolverInfo info_;
};

}  // namespace

std::unique_ptr<Solver> make_spring_solver(const Scene& scene) { return std::make_unique<SpringSolver>(scene); }

}  // namespace evenstep::internal
