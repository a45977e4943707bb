#include "evenstep/harness/watched_solver.h"

#include <glm/geometric.hpp>

namespace evenstep {
namespace {

double sum_N(const std::vector<DrawnTool>& tools) {
  double sum = 0;
  for (const DrawnTool& tool : tools) sum += glm::length(tool.force_N);
  return sum;
}

}  // namespace

double force_N(const TissuePose& pose) { return sum_N(pose.tools); }

ToolResponse WatchedSolver::step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s) {
  const ToolResponse response = solver_->step(positions_m, step_s);
  if (first_m_.empty()) first_m_.assign(positions_m.begin(), positions_m.end());
  for (std::size_t tool = 0; tool < tools_.size(); ++tool)
    tools_[tool] = {positions_m[tool] - first_m_[tool], response.force_N[tool]};
  const std::int64_t n = steps_++;
  if (every_ == 0 || steps_ % every_ != 0) return response;
  const double force_N = sum_N(tools_);
  // "At least" is also false for a force that is not a number.
  if (force_N >= 0 && (!most_ || force_N > evenstep::force_N(*most_)))
    most_ = TissuePose{n, solver_->particle_state(), tools_};
  return response;
}

void WatchedSolver::reset() {
  solver_->reset();
  first_m_.clear();
  tools_.assign(tools_.size(), {});
  most_.reset();
  steps_ = 0;
}

}  // namespace evenstep
