// What a step costs if another program or a library computes it, compared with the same step in this program: F = -k x for
// two tools, which itself takes no time.
//   bench_foreign_steps LIBRARY PROGRAM [ARGUMENT...]
// The least of 15 rounds counts, because time that other programs on this machine take does not belong to the step.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/plugins/library.h"
#include "evenstep/plugins/process_solver.h"

namespace {

using namespace evenstep;

class Spring final : public ForeignSolver {
  ToolResponse step(std::span<const glm::dvec3> positions_m, double) override {
    ToolResponse response;
    for (std::size_t tool = 0; tool < positions_m.size(); ++tool) response.force_N[tool] = positions_m[tool] * -200.0;
    return response;
  }
};

/// Seconds per step.
double cost_of(const SolverFactory& make, int steps) {
  const std::unique_ptr<ForeignSolver> solver = make({.step_s = 1.0 / 450, .tool_count = 2});
  double least_s = 1e9, sum = 0;
  for (int round = 0; round < 15; ++round) {
    const double begin_s = monotonic_seconds();
    for (int n = 0; n < steps; ++n) {
      const std::array at{glm::dvec3(1e-6 * n, 0, 0), glm::dvec3(0, 1e-6 * n, 0)};
      sum += solver->step(at, 1.0 / 450).force_N[0].x;
    }
    least_s = std::min(least_s, (monotonic_seconds() - begin_s) / steps);
  }
  if (sum > 0) fmt::print("the force pulls\n");
  return least_s;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return fmt::print(stderr, "usage: bench_foreign_steps LIBRARY PROGRAM [ARGUMENT...]\n"), 2;
  const Result<Library, std::string> library = open_library(argv[1]);
  if (!library) return fmt::print(stderr, "{}\n", library.error()), 2;
  fmt::print("one step, least of 15 rounds\n");
  fmt::print("  in this program  {:8.3f} us\n",
             1e6 * cost_of([](const SolverRequest&) { return std::make_unique<Spring>(); }, 100'000));
  fmt::print("  in a library     {:8.3f} us\n", 1e6 * cost_of(library->solver, 100'000));
  fmt::print("  in a process     {:8.3f} us\n",
             1e6 * cost_of(process_solver({.words = {argv + 2, argv + argc}, .folder = "."}), 2'000));
  return 0;
}
