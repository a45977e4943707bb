// The methods beyond symplectic Euler and velocity Verlet honour everything that a scene can have.
#include <thread>

#include "../feature_scenes.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::array kMethodsWithFeatures{Method::rk4, Method::implicit_euler, Method::implicit_midpoint,
                                      Method::vertex_block_descent};

/// 20 ms in which both tools move smoothly, in steps far below the limit.
std::vector<ToolResponse> smooth_run(const Has& has, int steps_per_s, int iterations) {
  TissueScene block = featured_block(has);
  block.substeps = 1;
  block.iterations = iterations;
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(block, 1.0 / steps_per_s));
  std::vector<ToolResponse> forces;
  const int steps = steps_per_s / 50;
  for (int n = 0; n <= steps; ++n) {
    const double t = static_cast<double>(n) / steps, s = t * t * t * (10 - 15 * t + 6 * t * t);
    const ToolResponse response = step(*solver, 2, {glm::dvec3(1e-3, 5e-4, -8e-4) * s, glm::dvec3(-5e-4, 6e-4, 1e-3) * s});
    if (n % (steps / 8) == 0) forces.push_back(response);
  }
  return forces;
}

double difference(const std::vector<ToolResponse>& a, const std::vector<ToolResponse>& b) {
  double worst_N = 0, largest_N = 0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      worst_N = std::max(worst_N, norm(a[n].force_N[tool] - b[n].force_N[tool]));
      largest_N = std::max(largest_N, norm(a[n].force_N[tool]));
    }
  }
  return worst_N / largest_N;
}

}  // namespace

// RK4 and velocity Verlet only ask for accelerations, each in its own way. Implicit methods need every force and also how it
// changes. All of them agree only if each honours every feature.
TEST_CASE(
    "In every combination of features with a grab, and in mixtures with the other tools, all methods come to the same "
    "forces",
    "[methods][features][sweep]") {
  for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::spring, CouplingKind::probe}) {
    for (unsigned bits = 0; bits < 16; ++bits) {
      Has has{(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, tool, Method::rk4};
      if (tool != CouplingKind::grab && bits != 0 && bits != 7 && bits != 9 && bits != 14 && bits != 15) continue;
      const auto expected = smooth_run(has, 20'000, 0);
      for (const Method method :
           {Method::velocity_verlet, Method::implicit_euler, Method::implicit_midpoint, Method::vertex_block_descent}) {
        has.method = method;
        const bool first_order = method == Method::implicit_euler || method == Method::vertex_block_descent;
        const double error = difference(smooth_run(has, 20'000, 4), expected);
        INFO(text_of(has) << ", method " << static_cast<int>(method) << ": " << error);
        CHECK(error < (first_order ? 0.04 : 3e-3));
        if (!first_order || bits != 15) continue;
        has.method = Method::rk4;
        const auto finer = smooth_run(has, 80'000, 0);
        has.method = method;
        CHECK(difference(smooth_run(has, 80'000, 4), finer) == Approx(error / 4).epsilon(0.2));
      }
    }
  }
}

TEST_CASE("Every method reports itself and its iterations, and starts again with the same bits", "[methods][features]") {
  for (const SolverKind kind : {SolverKind::cpu_float, SolverKind::cpu_double}) {
    for (const Method method : kMethodsWithFeatures) {
      for (const int iterations : {0, 7}) {
        TissueScene block = featured_block({true, true, true, true, CouplingKind::spring, method});
        block.iterations = iterations;
        block.initial_displacement_m.assign(static_cast<std::size_t>(block.particle_count), glm::dvec3(1e-5, 0, 0));
        Scene scene = scene_of(block, 1e-3, true);
        scene.variable_step = true;
        const auto solver = make_solver(kind, scene);
        CHECK(solver->info().method == method);
        CHECK((solver->info().iterations == 0) == (method == Method::rk4));
        if (iterations > 0 && method != Method::rk4) CHECK(solver->info().iterations == iterations);
        const auto run = [&] {
          std::vector<std::uint64_t> digests;
          for (int n = 0; n < 20; ++n) {
            const auto positions_m = wandering_tools(n);
            solver->step(std::span(positions_m), n % 3 == 0 ? 1e-3 : 0.7e-3);
            digests.push_back(solver->state_digest());
          }
          return digests;
        };
        const auto first = run();
        solver->reset();
        CHECK(run() == first);
        CHECK(first[0] != first[19]);
        CHECK_FALSE(solver->verdict().non_finite);
      }
    }
  }
}

TEST_CASE("A step of another length is the step of the scene whose constant step is that long, for every method",
          "[methods][variable]") {
  for (const SolverKind kind : {SolverKind::cpu_float, SolverKind::cpu_double}) {
    for (const Method method : kMethodsWithFeatures) {
      TissueScene block = featured_block({true, true, true, true, CouplingKind::grab, method});
      block.substeps = 2;
      Scene scene = scene_of(block, 1e-3, true);
      scene.variable_step = true;
      const auto free = make_solver(kind, scene);
      for (const double step_s : {1e-5, 0.4e-3}) {
        const Scene constant = scene_of(block, step_s, true);
        const auto other = make_solver(kind, constant);
        free->reset();
        for (int n = 0; n < 20; ++n) {
          const auto positions_m = wandering_tools(n);
          REQUIRE(same_bits(free->step(std::span(positions_m), period_s(constant.step_rate)), step(*other, 2, positions_m)));
          REQUIRE(free->state_digest() == other->state_digest());
        }
      }
    }
  }
}

TEST_CASE("Two blocks side by side in threads have the bits of one alone, for every method", "[methods]") {
  for (const Method method : kMethodsWithFeatures) {
    const Scene scene = scene_of(featured_block({true, false, true, true, CouplingKind::probe, method}), 1e-3);
    const auto run = [&] {
      const auto solver = make_solver(SolverKind::cpu_float, scene);
      for (int n = 0; n < 40; ++n) step(*solver, 2, wandering_tools(n));
      return solver->state_digest();
    };
    const std::uint64_t alone = run();
    std::array<std::uint64_t, 2> together{};
    std::thread first([&] { together[0] = run(); }), second([&] { together[1] = run(); });
    first.join();
    second.join();
    CHECK(together == std::array{alone, alone});
  }
}
