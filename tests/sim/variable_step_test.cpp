// Steps of different lengths: the integrator that the paper warns of (section 4).
#include <algorithm>
#include <limits>

#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr double kNominal_s = 1.0 / 450;

ToolResponse step(Solver& solver, int tools, const Positions& positions_m, double step_s) {
  return solver.step(std::span(positions_m.data(), static_cast<std::size_t>(tools)), step_s);
}

Scene variable(TissueScene tissue, double nominal_s, bool energy = false) {
  Scene scene = scene_of(std::move(tissue), nominal_s, energy);
  scene.variable_step = true;
  return scene;
}

TissueScene damped(double damping_per_s) {
  TissueScene block = small_block();
  block.damping_per_s = damping_per_s;
  return block;
}

/// The lengths of the paper's run: in each time segment one step is 5.66 times as long as the mean, and 14 have 0.667 of it.
double paper_length(int n) { return n % 15 == 0 ? 17.0 / 3 : 2.0 / 3; }

void require_equal(Solver& a, Solver& b) {
  REQUIRE(a.state_digest() == b.state_digest());
  REQUIRE(same_bits(a.verdict().energy_J, b.verdict().energy_J));
  REQUIRE(same_bits(a.verdict().energy_growth, b.verdict().energy_growth));
  REQUIRE(a.verdict().first_bad_step == b.verdict().first_bad_step);
  REQUIRE(a.verdict().steps_over_limit == b.verdict().steps_over_limit);
  REQUIRE(same_bits(a.verdict().step_over_limit_max, b.verdict().step_over_limit_max));
}

}  // namespace

TEST_CASE("Steps of the nominal length have the bits of a scene of constant steps, said or not", "[variable][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const double damping_per_s : {0.0, 20.0}) {
      const Scene constant = scene_of(damped(damping_per_s), kNominal_s, true);
      const Scene free = variable(damped(damping_per_s), kNominal_s, true);
      const auto today = make_solver(kind, constant), said = make_solver(kind, free), unsaid = make_solver(kind, free);
      step(*said, 2, wandering_tools(7), 1e-3);  // a length that was set before a reset is forgotten
      said->reset();
      for (int n = 0; n < 100; ++n) {
        const ToolResponse expected = test::step(*today, 2, wandering_tools(n));
        REQUIRE(same_bits(step(*said, 2, wandering_tools(n), period_s(constant.step_rate)), expected));
        REQUIRE(same_bits(test::step(*unsaid, 2, wandering_tools(n)), expected));
        require_equal(*said, *today);
        require_equal(*unsaid, *today);
      }
    }
  }
}

TEST_CASE("A step of another length is the step of the scene whose constant step is that long", "[variable][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    TissueScene block = damped(20);
    block.substeps = 4;
    const auto free = make_solver(kind, variable(block, kNominal_s, true));
    for (const double step_s : {1e-6, 2.5e-3}) {
      const Scene constant = scene_of(block, step_s, true);
      const auto other = make_solver(kind, constant);
      free->reset();
      for (int n = 0; n < 40; ++n) {
        const ToolResponse expected = test::step(*other, 2, wandering_tools(n));
        REQUIRE(same_bits(step(*free, 2, wandering_tools(n), period_s(constant.step_rate)), expected));
        require_equal(*free, *other);
      }
    }
  }
}

TEST_CASE("Steps without a length of their own are nominal again after others", "[variable]") {
  const auto left = make_solver(SolverKind::cpu_float, variable(small_block(), kNominal_s));
  const auto said = make_solver(SolverKind::cpu_float, variable(small_block(), kNominal_s));
  for (int n = 0; n < 60; ++n) {
    const Positions tools = wandering_tools(n);
    const bool nominal = n % 3 != 0;
    const double step_s = nominal ? period_s(scene_of(small_block(), kNominal_s).step_rate) : 1.3e-3;
    const ToolResponse expected = step(*said, 2, tools, step_s);
    REQUIRE(same_bits(nominal ? test::step(*left, 2, tools) : step(*left, 2, tools, step_s), expected));
    REQUIRE(left->state_digest() == said->state_digest());
  }
}

TEST_CASE("Steps of changing lengths are equal on cpu float and OpenCL, through overflow to NaN",
          "[variable][equality][sweep]") {
  for (const int work_group_size : {8, 64, 256}) {
    for (const double damping_per_s : {0.0, 20.0}) {
      if (damping_per_s > 0 && work_group_size != 64) continue;
      // With 0.15 every substep is below the limit. With 1 the long ones exceed it more than 4 times, and the run diverges.
      for (const double scale : {0.15, 1.0}) {
        const Scene scene = variable(damped(damping_per_s), kNominal_s, true);
        const auto cpu = make_solver(SolverKind::cpu_float, scene);
        const auto opencl = make_solver(SolverKind::opencl, scene, {"", work_group_size});
        INFO("work-group size " << work_group_size << ", damping " << damping_per_s << ", scale " << scale);
        for (int n = 0; n < 200; ++n) {
          const double step_s = scale * kNominal_s * paper_length(n) * (1 + 0.01 * (n % 7));
          REQUIRE(same_bits(step(*cpu, 2, wandering_tools(n), step_s), step(*opencl, 2, wandering_tools(n), step_s)));
          require_equal(*cpu, *opencl);
        }
        CHECK(cpu->verdict().non_finite == (scale == 1));
      }
    }
  }
}

// One free particle is on a held spring; a = w h1 and b = w h2. Two steps together have the matrix M(b) M(a), with
// determinant 1 and trace 2 - (a + b)^2 + a^2 b^2. A matrix solves its own characteristic equation (Cayley and Hamilton). So
// the force f, which is k times the distance from rest, follows f_n+4 = trace f_n+2 - f_n.
TEST_CASE("Alternating lengths on an oscillator follow the product of their two maps exactly", "[variable]") {
  const TissueScene pair = spring_pair();
  const double w_per_s = std::sqrt(pair.stiffness_N_per_m / pair.particle_mass_kg), jump_m = 1e-5;
  for (const auto& [a, b] : {std::pair{0.1, 0.3}, {0.7, 0.7}, {0.05, 1.3}, {1.0, 1.2}, {1.9, 0.1}, {1.2, 1.5}, {0.5, 2.4}}) {
    const auto solver = make_solver(SolverKind::cpu_double, variable(pair, 1e-4));
    step(*solver, 1, {}, 1e-4);
    long double u = 0, v = 0;
    std::vector<double> force_N;
    // An unstable pair of lengths is watched until the particle has moved by half the spacing. Beyond the whole spacing the
    // spring turns over and is no longer linear.
    const double large_N = 0.5 * pair.stiffness_N_per_m * pair.spacing_m;
    for (int n = 0; n < 1000 && (n == 0 || std::abs(force_N.back()) < large_N); ++n) {
      const long double h = (n % 2 == 0 ? a : b) / static_cast<long double>(w_per_s);
      force_N.push_back(step(*solver, 1, {glm::dvec3(jump_m, 0, 0)}, static_cast<double>(h)).force_N[0].x);
      v += h * w_per_s * w_per_s * ((n == 0 ? 0 : static_cast<long double>(jump_m)) - u);
      u += h * v;
      // Every step rounds by 1e-16 of the spacing (1e-13 of the motion), and these errors grow no more than the motion.
      const double scale_N = pair.stiffness_N_per_m * std::max(static_cast<double>(std::abs(u)), jump_m);
      INFO("w h = " << a << ", " << b << ", step " << n);
      REQUIRE(std::abs(force_N.back() - pair.stiffness_N_per_m * static_cast<double>(u - jump_m)) < 1e-8 * scale_N);
    }
    const double trace = 2 - (a + b) * (a + b) + a * a * b * b;
    for (std::size_t n = 1; n + 4 < force_N.size(); ++n) {
      const double largest_N = std::max({std::abs(force_N[n]), std::abs(force_N[n + 2]), std::abs(force_N[n + 4])});
      REQUIRE(std::abs(force_N[n + 4] - trace * force_N[n + 2] + force_N[n]) < 1e-9 * std::max(largest_N, 4e-4));
    }
    CHECK((force_N.size() < 1000) == (std::abs(trace) > 2));
  }
}

TEST_CASE("Damping and substeps of changing lengths enter as documented, in long double", "[variable]") {
  for (const double damping_per_s : {0.0, 5.0, 200.0}) {
    for (const int substeps : {1, 2, 5}) {
      TissueScene pair = spring_pair();
      pair.damping_per_s = damping_per_s;
      pair.substeps = substeps;
      const auto solver = make_solver(SolverKind::cpu_double, variable(pair, 2e-3));
      const long double k = pair.stiffness_N_per_m, m = pair.particle_mass_kg;
      long double u = 0, v = 0, tool = 0, worst = 0;
      step(*solver, 1, {}, 1e-3);
      for (int n = 1; n <= 500; ++n) {
        const double target_m = 1e-3 * (n % 100) / 50.0, step_s = 1e-4 * (1 + n * 7 % 25);
        const long double from = tool, h = static_cast<long double>(step_s) / substeps;
        for (int s = 1; s <= substeps; ++s) {
          v = (1 - h * damping_per_s) * v + h * k / m * (tool - u);
          u += h * v;
          tool = from + (target_m - from) * s / substeps;
        }
        const double force_N = step(*solver, 1, {glm::dvec3(target_m, 0, 0)}, step_s).force_N[0].x;
        worst = std::max(worst, std::abs(force_N - k * (u - tool)));
      }
      INFO("damping " << damping_per_s << ", substeps " << substeps);
      // As in closed_form_test, but ten times more, as the lengths resonate a little: roundings grow like the motion.
      CHECK(worst < 1e-11L);
    }
  }
}

TEST_CASE("Steps over the limit are counted with their largest ratio, and run", "[variable]") {
  for (const SolverKind kind : kEverySolver) {
    TissueScene block = small_block();
    block.substeps = 3;
    const double limit_s = 3 * step_limit(block).step_s;
    const auto solver = make_solver(kind, variable(block, 0.5 * limit_s));
    CHECK(solver->verdict().step_over_limit_max == 0);
    const auto check = [&](double ratio, std::int64_t over, double max) {
      step(*solver, 2, {}, ratio * limit_s);
      CHECK(solver->verdict().steps_over_limit == over);
      CHECK(solver->verdict().step_over_limit_max == Approx(max).epsilon(1e-14));
    };
    check(0.25, 0, 0.25);
    check(1 - 1e-9, 0, 1 - 1e-9);
    check(1 + 1e-9, 1, 1 + 1e-9);
    check(5.67, 2, 5.67);
    check(1.5, 3, 5.67);
    check(0.1, 3, 5.67);
    CHECK(solver->info().substeps == 3);
    CHECK_FALSE(solver->verdict().non_finite);  // nothing moved: at rest every length is stable
    solver->reset();
    CHECK(solver->verdict().steps_over_limit == 0);
    CHECK(solver->verdict().step_over_limit_max == 0);
  }
}

TEST_CASE("The nominal step is held to the limit as ever, and counted where it is allowed to be unstable", "[variable]") {
  TissueScene block = small_block();
  block.substeps = 1;
  Scene scene = variable(block, 1.5 * step_limit(block).step_s);
  CHECK_THROWS_AS(make_solver(SolverKind::cpu_float, scene), SolverError);
  scene.allow_unstable = true;
  for (const bool varies : {false, true}) {
    scene.variable_step = varies;
    const auto solver = make_solver(SolverKind::cpu_float, scene);
    for (int n = 1; n <= 5; ++n) {
      test::step(*solver, 2, {});
      CHECK(solver->verdict().steps_over_limit == n);
      CHECK(solver->verdict().step_over_limit_max == Approx(1.5).epsilon(1e-6));
    }
  }
}

TEST_CASE("Steps as long as the time since the last, in the paper's timing, diverge, even ones of their mean never do",
          "[variable][sweep]") {
  const Scene scene = variable(small_block(), kNominal_s, true);
  const auto even = make_solver(SolverKind::cpu_float, scene), uneven = make_solver(SolverKind::cpu_float, scene);
  int n = 0;
  for (; n < 150 && !uneven->verdict().non_finite; ++n) step(*uneven, 2, wandering_tools(n), kNominal_s * paper_length(n));
  CHECK(uneven->verdict().first_bad_step == n - 1);
  CHECK(uneven->verdict().steps_over_limit == (n + 14) / 15);
  CHECK(uneven->verdict().step_over_limit_max > 4);  // "auto" leaves the nominal step at 0.8 of the limit
  CHECK(std::isinf(uneven->verdict().energy_growth));
  for (n = 0; n < 3000; ++n) test::step(*even, 2, wandering_tools(std::min(n, 200)));
  CHECK_FALSE(even->verdict().non_finite);
  CHECK(even->verdict().energy_growth < 0.71);  // as in energy_test
  CHECK(even->verdict().steps_over_limit == 0);
}

// The limit holds for steps of equal length. A mode that makes a whole number of half turns in the pattern resonates.
TEST_CASE("A pattern of lengths can diverge though no step is over the limit", "[variable]") {
  TissueScene block = small_block();
  block.substeps = 1;
  const double longest_s = 0.999 * step_limit(block).step_s;
  const Scene scene = variable(block, longest_s, true);
  const auto even = make_solver(SolverKind::cpu_float, scene), uneven = make_solver(SolverKind::cpu_float, scene);
  int n = 0;
  for (; n < 15 * 400 && !uneven->verdict().non_finite; ++n) {
    step(*uneven, 2, wandering_tools(std::min(n, 20)), n % 15 == 0 ? longest_s : longest_s / 2);
    step(*even, 2, wandering_tools(std::min(n, 20)), longest_s);
  }
  CHECK(uneven->verdict().first_bad_step == n - 1);
  CHECK(uneven->verdict().steps_over_limit == 0);
  CHECK_FALSE(even->verdict().non_finite);
  CHECK(even->verdict().energy_growth < 0.71);
}

TEST_CASE("A length that is none, or that the scene has no use for, is refused and leaves the run as it was", "[variable]") {
  const double inf = std::numeric_limits<double>::infinity();
  for (const SolverKind kind : kEverySolver) {
    const auto solver = make_solver(kind, variable(small_block(), kNominal_s));
    const auto undisturbed = make_solver(kind, variable(small_block(), kNominal_s));
    const auto constant = make_solver(kind, scene_of(small_block(), kNominal_s));
    for (int n = 0; n < 5; ++n) {
      for (const double bad_s : {0.0, -1e-3, inf, -inf, std::nan(""), 1e-16, 1e16})
        REQUIRE_THROWS_AS(step(*solver, 2, wandering_tools(n + 50), bad_s), SolverError);
      REQUIRE_THROWS_AS(step(*constant, 2, wandering_tools(n + 50), kNominal_s), SolverError);
      const ToolResponse expected = step(*undisturbed, 2, wandering_tools(n), 1e-3 * (n + 1));
      REQUIRE(same_bits(step(*solver, 2, wandering_tools(n), 1e-3 * (n + 1)), expected));
      require_equal(*solver, *undisturbed);
    }
  }
}

TEST_CASE("The spring answers the same at any length", "[variable]") {
  Scene scene{SpringScene{200}};
  for (const bool varies : {false, true}) {
    scene.variable_step = varies;
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    for (const double step_s : {1e-6, 1.0 / 450, 7.0}) {
      const Positions positions_m{glm::dvec3(0.01, -0.02, 0.3)};
      CHECK(same_bits(step(*solver, 1, positions_m, step_s), test::step(*solver, 1, positions_m)));
    }
    CHECK(solver->verdict().steps_over_limit == 0);
  }
}
