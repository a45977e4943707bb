#include "foreign_substeps.h"

#include <algorithm>
#include <utility>

#include "evenstep/sim/foreign_solver.h"

namespace evenstep::internal {
namespace {

class Substeps final : public ForeignSolver {
 public:
  Substeps(std::unique_ptr<ForeignSolver> solver, int substeps) : solver_(std::move(solver)), substeps_(substeps) {}

  ToolResponse step(std::span<const glm::dvec3> positions_m, double step_s) override {
    std::array<glm::dvec3, kMaxTools> at_m{};
    if (!begun_) std::copy(positions_m.begin(), positions_m.end(), before_m_.begin());
    begun_ = true;
    ToolResponse response;
    for (int n = 1; n <= substeps_; ++n) {
      const double part = static_cast<double>(n) / substeps_;
      for (std::size_t tool = 0; tool < positions_m.size(); ++tool)
        at_m[tool] = n == substeps_ ? positions_m[tool] : before_m_[tool] + (positions_m[tool] - before_m_[tool]) * part;
      response = solver_->step({at_m.data(), positions_m.size()}, step_s / substeps_);
    }
    std::copy(positions_m.begin(), positions_m.end(), before_m_.begin());
    return response;
  }
  SolverCapabilities capabilities() const override { return solver_->capabilities(); }
  std::span<const ToolContact> contacts() const override { return solver_->contacts(); }
  std::uint64_t state_digest() override { return solver_->state_digest(); }
  double energy_J() override { return solver_->energy_J(); }
  ParticleState particles() override { return solver_->particles(); }
  void reset() override {
    solver_->reset();
    begun_ = false;
  }

 private:
  std::unique_ptr<ForeignSolver> solver_;
  int substeps_;
  bool begun_ = false;
  std::array<glm::dvec3, kMaxTools> before_m_{};
};

}  // namespace

ForeignScene with_substeps(const ForeignScene& scene, int substeps) {
  if (substeps == 1) return scene;
  ForeignScene changed = scene;
  changed.make = [make = scene.make, substeps](const SolverRequest& whole) -> std::unique_ptr<ForeignSolver> {
    SolverRequest request = whole;
    request.step_s /= substeps;
    std::unique_ptr<ForeignSolver> solver = make(request);
    if (!solver) return nullptr;  // the caller says so
    return std::make_unique<Substeps>(std::move(solver), substeps);
  };
  return changed;
}

}  // namespace evenstep::internal
