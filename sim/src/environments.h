#pragma once
/// The scenes other than a tissue that need a solver: spring, wall and mode, in closed form or nearly so. They are computed
/// in double whatever the kind of solver.

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {

std::unique_ptr<Solver> make_wall_solver(const Scene& scene);
std::unique_ptr<Solver> make_mode_solver(const Scene& scene);

// Shared by these solvers. The checks throw SolverError.

void check_stiffness(double stiffness_N_per_m, const char* of);
/// The normal scaled to length 1; throws SolverError if it has none.
glm::dvec3 unit_normal(const glm::dvec3& normal);
void check_positions(std::span<const glm::dvec3> positions_m);

/// k n n': the stiffness of a spring along n.
glm::dmat3 along(const glm::dvec3& n, double stiffness_N_per_m);
/// The number of contacts to keep: one per tool if they will be read, otherwise none.
std::size_t contact_count(const Scene& scene);

/// What a solver without particles has in common with the others.
class EnvironmentSolver : public Solver {
 public:
  std::span<const ToolContact> contacts() const final { return contacts_; }
  std::uint64_t state_digest() override { return 0; }
  void reset() override { std::fill(contacts_.begin(), contacts_.end(), ToolContact{}); }
  ParticleState particle_state() final { return {}; }
  SolverVerdict verdict() final { return {}; }
  const SolverInfo& info() const final { return info_; }

 protected:
  explicit EnvironmentSolver(const Scene& scene) : contacts_(contact_count(scene)) {
    info_.name = "cpu-double";
    info_.left_out = evenstep::left_out(scene);
  }
  std::vector<ToolContact> contacts_;
  SolverInfo info_;
};

}  // namespace evenstep::internal
