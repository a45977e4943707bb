#pragma once
/// A tissue's solver that can be watched: it passes every call on to the solver, and knows where the tools are and what
/// their hands feel. It changes no bit of what the solver computes.

#include <memory>
#include <optional>
#include <vector>

#include "evenstep/draw/tissue_mesh.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

/// A tissue at the end of a step.
struct TissuePose {
  std::int64_t step = -1;
  ParticleState state;
  std::vector<DrawnTool> tools;
};
/// The sum of the forces on the hands, N.
double force_N(const TissuePose& pose);

class WatchedSolver final : public Solver {
 public:
  /// Of the poses after every `every` steps, the one with the largest sum of forces is kept; 0: none is kept.
  WatchedSolver(std::unique_ptr<Solver> solver, int tool_count, std::int64_t every = 0)
      : solver_(std::move(solver)), every_(every), tools_(static_cast<std::size_t>(tool_count)) {}

  const std::vector<DrawnTool>& tools() const { return tools_; }  ///< after the last step
  /// Empty as long as no force was felt.
  const std::optional<TissuePose>& most_forceful() const { return most_; }

  ToolResponse step(std::span<const glm::dvec3> positions_m, std::optional<double> step_s = std::nullopt) override;
  std::span<const ToolContact> contacts() const override { return solver_->contacts(); }
  std::uint64_t state_digest() override { return solver_->state_digest(); }
  void reset() override;
  ParticleState particle_state() override { return solver_->particle_state(); }
  SolverVerdict verdict() override { return solver_->verdict(); }
  const SolverInfo& info() const override { return solver_->info(); }
  CommandLog* command_log() override { return solver_->command_log(); }

 private:
  std::unique_ptr<Solver> solver_;
  std::int64_t every_, steps_ = 0;
  std::vector<glm::dvec3> first_m_;
  std::vector<DrawnTool> tools_;
  std::optional<TissuePose> most_;
};

}  // namespace evenstep
