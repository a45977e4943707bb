#pragma once
/// The solver as the simulation lane starts it.

#include <array>
#include <cstdint>
#include <optional>

#include "evenstep/device/renderer.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/scheduler/work.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

/// A solver's error as the reason why a run stopped; at_step -1: before the first step.
RunFailure run_failure(const SolverError& error, std::int64_t at_step = -1);

/// One step of the solver as work for an executor; owned by whoever owns the solver.
class SolverStep final : public Work {
 public:
  SolverStep(Solver& solver, const Scene& scene)
      : solver_(solver),
        tool_count_(scene.tool_count),
        digest_(scene.needs_state_digest),
        variable_(scene.variable_step),
        step_s_(period_s(scene.step_rate)) {}
  std::array<glm::dvec3, kMaxTools> positions_m{};  ///< in
  ToolResponse response;                            ///< out
  std::uint64_t state_digest = 0;                   ///< out
  double seconds = 0;                               ///< host time spent so far; reported, never hashed
  /// The step about to run gets this position, where the hand was at `read_at`.
  void give(int tool, const glm::dvec3& position_m, RealTime read_at);
  /// What the last step leaves for the device lane. Without Scene::local_model it is the force alone.
  ContactRecord contact(int tool) const;
  /// The step about to run begins at `began`: with a variable step size it advances by the real time since the one before
  /// (the first one by the nominal step size).
  void begins(RealTime began);
  void run() override;
  /// Simulation time at which the tools reach `positions_m`, counted from the first step's: n step sizes where they are
  /// constant.
  double simulated_s() const { return simulated_s_; }

 private:
  Solver& solver_;
  int tool_count_;
  bool digest_;
  bool variable_;
  std::array<RealTime, kMaxTools> read_at_{};
  double step_s_;  // of the step about to run
  double simulated_s_ = 0;
  std::optional<RealTime> began_;
  std::int64_t step_ = 0;
};

}  // namespace evenstep
