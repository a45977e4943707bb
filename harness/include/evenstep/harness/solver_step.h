#pragma once
/// The solver as the simulation lane starts it.

#include <array>
#include <cstdint>

#include "evenstep/scheduler/work.h"
#include "evenstep/sim/solver.h"

namespace evenstep {

/// One step of the solver as work for an executor; owned by whoever owns the solver.
class SolverStep final : public Work {
 public:
  explicit SolverStep(Solver& solver, int tool_count, bool digest)
      : solver_(solver), tool_count_(tool_count), digest_(digest) {}
  std::array<glm::dvec3, kMaxTools> positions_m{};  ///< in
  ToolResponse response;                            ///< out
  std::uint64_t state_digest = 0;                   ///< out
  double seconds = 0;                               ///< host time spent so far; reported, never hashed
  void run() override;

 private:
  Solver& solver_;
  int tool_count_;
  bool digest_;
  std::int64_t step_ = 0;
};

}  // namespace evenstep
