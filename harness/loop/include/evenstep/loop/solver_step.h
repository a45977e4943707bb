#pragma once
/// A step of the solver as work that the simulation lane starts.

#include <array>
#include <cstdint>
#include <optional>

#include "evenstep/device/renderer.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/scheduler/work.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

/// Turns an error of the solver into the reason why a run stopped; at_step -1: before the first step.
RunFailure run_failure(const SolverError& error, std::int64_t at_step = -1);

/// One step of the solver as work for an executor. It belongs to the owner of the solver.
class SolverStep final : public Work {
 public:
  SolverStep(Solver& solver, const Scene& scene)
      : solver_(solver),
        tool_count_(scene.tool_count),
        digest_(scene.needs_state_digest),
        variable_(scene.variable_step),
        step_rate_(scene.step_rate),
        step_s_(period_s(scene.step_rate)) {}
  std::array<glm::dvec3, kMaxTools> positions_m{};  ///< input
  ToolResponse response;                            ///< output
  std::uint64_t state_digest = 0;                   ///< output
  std::int64_t begun = 0;                           ///< steps so far, including the one that runs
  double seconds = 0;                               ///< host time spent so far; reported, never hashed
  /// Sets the position for the next step: where the hand was at `read_at`.
  void give(int tool, const glm::dvec3& position_m, RealTime read_at);
  /// The record that the last step leaves for the device lane. Without Scene::local_model it contains only the force.
  ContactRecord contact(int tool) const;
  /// The next step begins at `began`. With a variable step size it advances by the real time since the step before it (the
  /// first step by the nominal step size).
  void begins(RealTime began);
  void run() override;
  /// Simulation time at which the tools reach `positions_m`, counted from the first step's: n step sizes where they are
  /// constant, otherwise the real time since the first step began.
  SimTime simulated() const { return simulated_; }

 private:
  Solver& solver_;
  int tool_count_;
  bool digest_;
  bool variable_;
  std::array<RealTime, kMaxTools> read_at_{};
  Rate step_rate_;
  double step_s_;  // length of the next step
  SimTime simulated_;
  std::optional<RealTime> first_began_, began_;
  std::int64_t step_ = 0;
};

}  // namespace evenstep
