
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

// One particle on a spring whose other end the tool moves by X in step 1 and then holds: with w^2 = k/m and
// 2 - 2 cos(theta) = (w h)^2, symplectic Euler gives y_n = -X cos(theta (n - 1/2)) / cos(theta / 2) for the distance y of
// the particle from where it would rest, and the hand feels k y_n.
TEST_CASE("A held spring pair oscillates as the discrete solution of symplectic Euler says, up to the step limit",
          "[closed][sweep]") {
  constexpr int kSteps = 5'000;
  const double jump_m = 1e-4;  // swings up to 1 / cos(theta / 2) = 10 times as far, a tenth of the spacing
  TissueScene pair = spring_pair();
  const double w_per_s = std::sqrt(pair.stiffness_N_per_m / pair.particle_mass_kg);
  for (const double wh : {0.01, 0.1, 0.3, 0.7, 1.0, 1.3, 1.6, 1.9, 1.99}) {
    Scene scene = scene_of(pair, wh / w_per_s);
    scene.allow_unstable = true;  // the limit is for any two free particles (2 k/m); here only one is free (k/m)
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    const double h_s = period_s(scene.step_rate), theta = std::acos(1 - w_per_s * w_per_s * h_s * h_s / 2);
    step(*solver, 1, {});
    double worst_N = 0;
    for (int n = 1; n <= kSteps; ++n) {
      const double force_N = step(*solver, 1, {glm::dvec3(jump_m, 0, 0)}).force_N[0].x;
      const double expected_N = -pair.stiffness_N_per_m * jump_m * std::cos(theta * (n - 0.5)) / std::cos(theta / 2);
      worst_N = std::max(worst_N, std::abs(force_N - expected_N));
    }
    // Every step rounds by 1e-16 of the spacing (100 jumps). That moves the phase, and more so for a smaller sin(theta) >=
    // 0.1. With random signs it makes sqrt(5000) * 1e-14 / 0.1 = 7e-12 of the amplitude.
    INFO("w h = " << wh);
    CHECK(worst_N < 1e-10 * pair.stiffness_N_per_m * jump_m / std::cos(theta / 2));
  }
}

TEST_CASE("Damping and substeps enter as documented: the pair follows its recurrence in long double", "[closed][sweep]") {
  for (const double damping_per_s : {0.0, 1.0, 20.0, 400.0}) {
    for (const int substeps : {1, 2, 3, 7}) {
      TissueScene pair = spring_pair();
      pair.damping_per_s = damping_per_s;
      pair.substeps = substeps;
      const Scene scene = scene_of(pair, 2e-3);
      const auto solver = make_solver(SolverKind::cpu_double, scene);
      const long double h = static_cast<long double>(period_s(scene.step_rate)) / substeps;
      const long double k = pair.stiffness_N_per_m, m = pair.particle_mass_kg;
      long double u = 0, v = 0, tool = 0, worst = 0;
      step(*solver, 1, {});
      for (int n = 1; n <= 500; ++n) {
        const double target_m = 1e-3 * (n % 100) / 50.0 - 5e-4 * (n / 300);  // ramps and jumps
        const long double from = tool;
        for (int s = 1; s <= substeps; ++s) {
          v = (1 - h * damping_per_s) * v + h * k / m * (tool - u);
          u += h * v;
          tool = from + (target_m - from) * s / substeps;
        }
        const double force_N = step(*solver, 1, {glm::dvec3(target_m, 0, 0)}).force_N[0].x;
        worst = std::max(worst, std::abs(force_N - k * (u - tool)));
      }
      INFO("damping " << damping_per_s << ", substeps " << substeps);
      // Each of 3500 substeps rounds by 1e-16 of the spacing. That makes at most 1e-14 m or 4e-13 N.
      CHECK(worst < 1e-12L);
    }
  }
}

// Every particle is held: the lower layer by tool 0, the upper one by tool 1. At a displacement d the force on the upper
// layer is n k (r - a) r/|r| from the n upright springs, plus that of the diagonals in each of the four directions.
TEST_CASE("Two rigid layers pull at each other with the sum over their springs, in every direction", "[closed]") {
  for (const auto& [nx, ny] : {std::pair{2, 2}, {2, 5}, {4, 3}, {7, 7}}) {
    TissueScene layers;
    const double a = layers.spacing_m, k = layers.stiffness_N_per_m;
    layers.lattice = {nx, ny, 2};
    layers.particle_count = nx * ny * 2;
    layers.fixed = FixedFaces::none();
    layers.tools.clear();
    // Balls that reach every site of one layer and none of the other: far below, far above.
    const double far_m = 1e3 * a, reach_m = far_m + 0.5 * a;
    const glm::dvec3 middle_m(0.5 * (nx - 1) * a, 0.5 * (ny - 1) * a, 0);
    layers.tools = {{middle_m - glm::dvec3(0, 0, far_m), reach_m}, {middle_m + glm::dvec3(0, 0, a + far_m), reach_m}};
    const auto solver = make_solver(SolverKind::cpu_double, scene_of(layers, 1e-4));
    step(*solver, 2, {});
    for (int n = 0; n < 300; ++n) {
      const glm::dvec3 d = glm::dvec3((n * 37 % 101) / 50.0 - 1, (n * 53 % 101) / 50.0 - 1, (n * 71 % 101) / 40.0 - 0.8) * a;
      glm::dvec3 expected_N(0);
      const auto add = [&](int count, double rx, double ry) {
        const glm::dvec3 r = glm::dvec3(rx, ry, a) + d;  // from below to above
        expected_N += r * (-count * k * (1 - std::sqrt(rx * rx + ry * ry + a * a) / norm(r)));
      };
      add(nx * ny, 0, 0);
      add((nx - 1) * ny, a, 0);
      add((nx - 1) * ny, -a, 0);
      add(nx * (ny - 1), 0, a);
      add(nx * (ny - 1), 0, -a);
      const ToolResponse response = step(*solver, 2, {glm::dvec3(0), d});
      // 250 terms of at most k * 3 a, each of them right to a few 1e-16.
      REQUIRE(norm(response.force_N[1] - expected_N) < 1e-13 * k * a * nx * ny);
      REQUIRE(norm(response.force_N[0] + expected_N) < 1e-13 * k * a * nx * ny);
    }
  }
}

namespace {

/// Makes steps until the damped block is at rest.
ToolResponse settle(Solver& solver, int tools, const Positions& positions_m) {
  ToolResponse response;
  for (int n = 0; n < 6000; ++n) response = step(solver, tools, positions_m);
  return response;
}

TissueScene damped_block() {
  TissueScene block;
  block.lattice = {5, 4, 6};
  block.particle_count = 5 * 4 * 6 - 3;
  block.damping_per_s = 60;
  return block;
}

}  // namespace

TEST_CASE("At rest the pulled block pulls as hard at its bottom as at the hand, and a held bottom is a fixed one",
          "[closed]") {
  TissueScene block = damped_block();
  const double a = block.spacing_m;
  const ToolCoupling top{glm::dvec3(2, 1.5, 4) * a, 0.6 * a};
  const ToolCoupling bottom{glm::dvec3(2, 1.5, -1000) * a, 1000.01 * a};
  block.tools = {top};
  const auto fixed = make_solver(SolverKind::cpu_double, scene_of(block, 5e-4));
  block.fixed = FixedFaces::none();
  block.tools = {top, bottom};
  const auto held = make_solver(SolverKind::cpu_double, scene_of(block, 5e-4));

  const Positions pulled{glm::dvec3(3e-3, -2e-3, 6e-3), glm::dvec3(0)};
  step(*fixed, 1, {});
  step(*held, 2, {});
  const ToolResponse alone = settle(*fixed, 1, pulled), both = settle(*held, 2, pulled);
  REQUIRE(norm(alone.force_N[0]) > 0.1);
  CHECK(norm(both.force_N[0] + both.force_N[1]) <
        1e-9 * norm(both.force_N[0]));  // damping leaves exp(-60 * 3 s / 2) of the motion
  CHECK(same_bits(both.force_N[0].x, alone.force_N[0].x));
  CHECK(same_bits(both.force_N[0].y, alone.force_N[0].y));
  CHECK(same_bits(both.force_N[0].z, alone.force_N[0].z));
}

TEST_CASE("Mirrored grabs feel mirrored forces", "[closed]") {
  TissueScene block;
  block.lattice = {9, 5, 6};
  block.particle_count = 9 * 5 * 6;
  const double a = block.spacing_m;
  block.tools = {{glm::dvec3(1, 2, 5) * a, 1.1 * a}, {glm::dvec3(7, 2, 5) * a, 1.1 * a}};
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(block, 5e-4));
  double largest_N = 0;
  for (int n = 0; n < 150; ++n) {
    const glm::dvec3 m = wandering_tools(n)[0];
    const auto [left_N, right_N] = step(*solver, 2, {m, glm::dvec3(-m.x, m.y, m.z)}).force_N;
    largest_N = std::max(largest_N, norm(left_N));
    // On the other side the sums run in another order. Their roundings of 1e-16 grow while the block is pulled to twice its
    // length (to 1e-12 after 150 steps; soon after, they are chaotic). A lost spring or a wrong neighbour would show at once
    // and in full.
    REQUIRE(norm(left_N - glm::dvec3(-right_N.x, right_N.y, right_N.z)) < 1e-10 * std::max(largest_N, 0.01));
  }
  CHECK(largest_N > 0.1);
}

TEST_CASE("A tool that pulls back to a coincident particle gets a finite force", "[closed]") {
  // The held end of the pair goes exactly where the other particle is: a spring of no length has no direction.
  for (const SolverKind kind : kEverySolver) {
    TissueScene pair = spring_pair();
    pair.spacing_m = 0.0078125;   // exact in float and double
    pair.particle_mass_kg = 1e3;  // stays where it is
    const auto solver = make_solver(kind, scene_of(pair, 1e-6));
    step(*solver, 1, {});
    const ToolResponse response = step(*solver, 1, {glm::dvec3(pair.spacing_m, 0, 0)});
    CHECK(response.force_N[0] == glm::dvec3(0));
    CHECK_FALSE(solver->verdict().non_finite);
  }
}
