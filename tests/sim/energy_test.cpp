
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

// Symplectic Euler keeps p^2 + q^2 - (w h) p q (p = v, q = w y), so from rest at energy E0 = W the energy swings up to
// E0 / (1 - w h / 2): the growth over its scale is w h / 2.
TEST_CASE("energy_growth of a spring pair is half of w h, its closed form", "[energy][sweep]") {
  TissueScene pair = spring_pair();
  const double w_per_s = std::sqrt(pair.stiffness_N_per_m / pair.particle_mass_kg), jump_m = 1e-3;
  for (const double wh : {0.02, 0.1, 0.3, 0.6, 1.0, 1.5}) {
    Scene scene = scene_of(pair, wh / w_per_s, true);
    scene.allow_unstable = true;  // it is stable nevertheless, because one of the two particles is held
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    step(*solver, 1, {});
    CHECK(solver->verdict().energy_J == 0);
    double largest_J = 0;
    for (int n = 0; n < 5'000; ++n) {
      step(*solver, 1, {glm::dvec3(jump_m, 0, 0)});
      largest_J = std::max(largest_J, solver->verdict().energy_J);
      if (n == 0) CHECK(solver->verdict().energy_J == Approx(pair.stiffness_N_per_m * jump_m * jump_m / 2).epsilon(1e-12));
    }
    INFO("w h = " << wh);
    // 5000 phases catch the maximum of the swing to within (1e-3)^2.
    CHECK(solver->verdict().energy_growth == Approx(wh / 2).epsilon(1e-3));
    CHECK(largest_J == Approx(pair.stiffness_N_per_m * jump_m * jump_m / 2 / (1 - wh / 2)).epsilon(1e-3));
  }
}

TEST_CASE("Below the limit the energy of a tugged block is the tools' work for 10^4 steps", "[energy][cpu][sweep]") {
  for (const double part_of_limit : {0.4, 0.9}) {
    TissueScene block = small_block();
    block.substeps = 1;
    const auto solver = make_solver(SolverKind::cpu_double, scene_of(block, part_of_limit * step_limit(block).step_s, true));
    for (int n = 0; n < 10'000; ++n) step(*solver, 2, wandering_tools(std::min(n, 200)));
    INFO("step at " << part_of_limit << " of the limit");
    // The closed form above gives w h / 2 = part * sqrt(12 / 24) for the fastest mode at rest.
    CHECK(solver->verdict().energy_growth < part_of_limit * 0.71);
    CHECK(solver->verdict().energy_J > 0);
  }
}

TEST_CASE("Damping takes energy and never gives any", "[energy]") {
  TissueScene block = small_block();
  block.substeps = 4;
  block.damping_per_s = 50;
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(block, 1e-3, true));
  for (int n = 0; n < 200; ++n) step(*solver, 2, wandering_tools(n));
  double before_J = solver->verdict().energy_J;
  for (int n = 0; n < 10; ++n) {  // 200 ms, in which damping leaves exp(-5) of the speed
    for (int s = 0; s < 20; ++s) step(*solver, 2, wandering_tools(199));
    CHECK(solver->verdict().energy_J < before_J);
    before_J = solver->verdict().energy_J;
  }
}

TEST_CASE("A diverging block is told by its energy: growth near 1, then infinite", "[energy]") {
  TissueScene block = small_block();
  block.substeps = 1;
  Scene scene = scene_of(block, 2.2 * step_limit(block).step_s, true);
  scene.allow_unstable = true;
  const auto solver = make_solver(SolverKind::cpu_float, scene);
  bool seen_growth = false;
  int n = 0;
  for (; n < 2000 && !solver->verdict().non_finite; ++n) {
    step(*solver, 2, wandering_tools(n % 200));
    seen_growth |= solver->verdict().energy_growth > 0.99 && !solver->verdict().non_finite;
  }
  CHECK(seen_growth);
  CHECK(solver->verdict().non_finite);
  CHECK(solver->verdict().first_bad_step == n - 1);
  CHECK(std::isinf(solver->verdict().energy_growth));
  solver->reset();
  CHECK_FALSE(solver->verdict().non_finite);
  CHECK(solver->verdict().energy_growth == 0);
}

TEST_CASE("Held particles bring no kinetic energy: a tool in steady motion alone adds none", "[energy]") {
  TissueScene pair = spring_pair();
  pair.tools = {{glm::dvec3(0), 1.1 * pair.spacing_m}};  // holds both
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(pair, 1e-3, true));
  for (int n = 0; n < 100; ++n) step(*solver, 1, {glm::dvec3(1e-3 * n, 0, 0)});
  CHECK(solver->verdict().energy_J == 0);
  CHECK(solver->verdict().energy_growth == 0);
}
