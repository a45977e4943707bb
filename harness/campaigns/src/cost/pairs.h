#pragma once
/// Pairs of solvers that step side by side, and libraries opened in processes of their own.

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "evenstep/campaigns/cost.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

/// One side of a pair: the solver, and what a run asks of it after each step.
struct Side {
  std::unique_ptr<Solver> solver;
  Scene scene;
};
using ToolPath = std::vector<std::array<glm::dvec3, kMaxTools>>;  ///< per step, positions, m

struct StepPairs {
  std::vector<double> with_s, without_s;  ///< CPU time per pair
  bool same_bits = true;                  ///< forces after every step; the particles' digest too where both sides have one
  bool compared_particles = false;
  std::int64_t steps = 0;  ///< of each side
};
/// Lets both make the same steps along the path, some at a time; the two alternate in going first. At the end of the path
/// both are reset and begin again.
StepPairs step_pairs(Side& with, Side& without, const ToolPath& path, const CostOptions& options);

/// What opening a library takes in a process that has not opened it yet. Each time is measured in a new process.
struct Opened {
  Measured cpu_ms, resident_MiB;
  std::string error;  ///< if it cannot be opened
};
/// `open` throws if it fails. To be called before this process has opened the library itself.
Opened opened_in_children(const std::function<void()>& open, int times);

}  // namespace evenstep::internal
