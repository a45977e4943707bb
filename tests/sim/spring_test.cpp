
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("The spring answers -k x exactly, for every solver kind and any order of samples", "[spring]") {
  for (const SolverKind kind : kEverySolver) {
    for (const double stiffness : {1e-3, 200.0, 1.0 / 3, 1e9}) {
      Scene scene{SpringScene{stiffness}};
      scene.tool_count = 2;
      const auto solver = make_solver(kind, scene);
      for (int n = -500; n <= 500; ++n) {
        const double x = (n * 7919 % 1001) * 1e-4;  // every thousandth of the range once, out of order
        const Positions positions_m{glm::dvec3(x, -x, x / 3), glm::dvec3(0, x, 1)};
        const ToolResponse response = step(*solver, 2, positions_m);
        for (int tool = 0; tool < 2; ++tool) {
          for (int axis = 0; axis < 3; ++axis) REQUIRE(response.force_N[tool][axis] == -stiffness * positions_m[tool][axis]);
        }
      }
    }
  }
}

TEST_CASE("A spring has no state: no digest, no limit, no particles, nothing to reset", "[spring]") {
  const auto solver = make_solver(SolverKind::cpu_double, Scene{SpringScene{}});
  const ToolResponse first = step(*solver, 1, {glm::dvec3(1, 2, 3)});
  CHECK(solver->state_digest() == 0);
  CHECK_FALSE(solver->info().limit);
  CHECK(solver->info().particles == 0);
  solver->reset();
  CHECK(same_bits(step(*solver, 1, {glm::dvec3(1, 2, 3)}), first));
  CHECK_FALSE(solver->verdict().non_finite);
}
