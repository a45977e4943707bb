// Implicit methods at any stiffness, bad starts, and the step limit of RK4.
#include <complex>

#include "../tissue_scenes.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::array kImplicit{Method::implicit_euler, Method::implicit_midpoint, Method::vertex_block_descent};

/// Largest displacement and speed of any particle.
std::pair<double, double> largest(Solver& solver) {
  const ParticleState state = solver.particle_state();
  double u = 0, v = 0;
  for (const glm::dvec3& x : state.displacement_m) u = std::max(u, norm(x));
  for (const glm::dvec3& x : state.velocity_m_per_s) v = std::max(v, norm(x));
  return {u, v};
}

}  // namespace

// The tool moves by 2 cm in 0.2 s, in steps of 1 ms. h sqrt(k / m) goes from 1e-2 to 1e3, with the lightest particles to
// 1e4.
TEST_CASE("Lifting held particles stays finite and bounded in implicit methods for ten decades of stiffness",
          "[methods][robust][sweep]") {
  for (const Method method : kImplicit) {
    for (const int iterations : {0, 1}) {
      for (const SolverKind kind : {SolverKind::cpu_float, SolverKind::cpu_double}) {
        if (iterations == 0 && kind == SolverKind::cpu_double) continue;  // float is the harder case
        for (double stiffness = 1e-2; stiffness < 2e8; stiffness *= 10) {
          TissueScene block = small_block();
          block.method = method;
          block.iterations = iterations;
          block.stiffness_N_per_m = stiffness;
          if (stiffness > 5e7) block.particle_mass_kg = 1e-6;
          block.tools.resize(1);
          Scene scene = scene_of(block, 1e-3, true);
          const auto solver = make_solver(kind, scene);
          REQUIRE(solver->info().substeps == 1);
          for (int n = 0; n <= 125; ++n) step(*solver, 1, {glm::dvec3(0, 0, std::min(0.02, 2e-4 * n))});
          const auto [u_m, v_m_per_s] = largest(*solver);
          INFO("method " << static_cast<int>(method) << ", k = " << stiffness << ", " << iterations << " iterations: " << u_m
                         << " m, " << v_m_per_s << " m/s, growth " << solver->verdict().energy_growth);
          REQUIRE_FALSE(solver->verdict().non_finite);
          CHECK(u_m < 0.06);                                                     // three times the motion of the tool
          if (method == Method::implicit_midpoint && iterations == 1) continue;  // not promised (cpu/methods/implicit.cpp)
          CHECK(solver->verdict().energy_growth < 0.01);
        }
      }
    }
  }
}

// docs/choose/numerics.md, S17: springs cannot tell inside from outside. So the test asks only for bounded energy and no
// NaN.
TEST_CASE(
    "Blocks that start flattened to a plane, to a point or thrown about stay finite, and gain no energy from implicit Euler",
    "[methods][robust][sweep]") {
  for (const Method method : kImplicit) {
    for (const SolverKind kind : {SolverKind::cpu_float, SolverKind::cpu_double}) {
      for (const double stiffness : {20.0, 2e5}) {
        for (const double shape : {-2.0, -1.0, 0.01, 1.0, 100.0}) {  // a point, a plane, or random by this many spacings
          TissueScene block = small_block();
          block.method = method;
          block.stiffness_N_per_m = stiffness;
          block.fixed = FixedFaces::none();
          block.tools.clear();
          std::uint32_t seed = 7;
          const auto random = [&] {
            return static_cast<double>((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 23) - 1;
          };
          for (std::int64_t site = 0; site < block.particle_count; ++site) {
            const glm::dvec3 at_m = glm::dvec3(site % 8, site / 8 % 7, site / 56) * block.spacing_m;
            const glm::dvec3 to_random(random(), random(), random());
            block.initial_displacement_m.push_back(shape == -2.0   ? -at_m
                                                   : shape == -1.0 ? glm::dvec3(0, 0, -at_m.z)
                                                                   : to_random * (shape * block.spacing_m));
          }
          const auto solver = make_solver(kind, scene_of(block, 1e-3, true));
          for (int n = 0; n < 60; ++n) step(*solver, 0, {});
          INFO("method " << static_cast<int>(method) << ", k = " << stiffness << ", shape " << shape << ", growth "
                         << solver->verdict().energy_growth);
          REQUIRE_FALSE(solver->verdict().non_finite);
          if (method != Method::implicit_midpoint) CHECK(solver->verdict().energy_growth < 0.05);
        }
      }
    }
  }
}

TEST_CASE("A rest that is exact stays exact: implicit methods do not divide nothing by nothing", "[methods][robust]") {
  for (const Method method :
       {Method::rk4, Method::implicit_euler, Method::implicit_midpoint, Method::vertex_block_descent}) {
    for (const SolverKind kind : {SolverKind::cpu_float, SolverKind::cpu_double}) {
      for (const double speed_m_per_s : {0.0, 1e-30, 1e-300}) {
        TissueScene block = small_block();
        block.method = method;
        block.iterations = 500;
        block.tools.clear();
        block.initial_velocity_m_per_s.assign(static_cast<std::size_t>(block.particle_count),
                                              glm::dvec3(speed_m_per_s, 0, 0));
        const auto solver = make_solver(kind, scene_of(block, 1e-3, true));
        for (int n = 0; n < 3; ++n) step(*solver, 0, {});
        CHECK_FALSE(solver->verdict().non_finite);
        CHECK(largest(*solver).first < 1e-16);  // a few roundings of the spacing; springs turn them into speed
      }
    }
  }
}

TEST_CASE("A free block in uniform motion keeps it exactly however few iterations there are", "[methods]") {
  for (const Method method : kImplicit) {
    TissueScene block = small_block();
    block.method = method;
    block.iterations = 1;
    block.fixed = FixedFaces::none();
    block.tools.clear();
    block.stiffness_N_per_m = 2e5;
    block.initial_velocity_m_per_s.assign(static_cast<std::size_t>(block.particle_count), glm::dvec3(0.3, -0.2, 0.1));
    const auto solver = make_solver(SolverKind::cpu_double, scene_of(block, 1e-3));
    for (int n = 0; n < 100; ++n) step(*solver, 0, {});
    for (const glm::dvec3& u : solver->particle_state().displacement_m)
      REQUIRE(norm(u - glm::dvec3(0.03, -0.02, 0.01)) < 1e-12);
  }
}

TEST_CASE("RK4 is stable up to its limit and grows 1 % above it on an undamped oscillator", "[methods][stability]") {
  TissueScene pair = spring_pair();
  pair.method = Method::rk4;
  pair.initial_displacement_m = {glm::dvec3(0), glm::dvec3(1e-6, 0, 0)};
  const double w_per_s = std::sqrt(pair.stiffness_N_per_m / pair.particle_mass_kg);
  const double limit_s = largest_stable_step_s(Method::rk4, w_per_s * w_per_s, 0);
  CHECK(limit_s * w_per_s == Approx(std::sqrt(8.0)).epsilon(1e-14));
  const auto amplitude = [&](double step_s) {
    Scene scene = scene_of(pair, step_s);
    scene.allow_unstable = true;
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    for (int n = 0; n < 300; ++n) step(*solver, 1, {});
    return largest(*solver).first;
  };
  CHECK(amplitude(0.99 * limit_s) < 1e-6);  // |R| = 1 - 0.08: dissipates
  CHECK(amplitude(1.01 * limit_s) > 1e-3);  // |R| = 1 + 0.08
}

// The growth is |R(z)| for the two roots z of z^2 + h g z + h^2 w^2 = 0, the eigenvalues of the companion matrix.
TEST_CASE("The limit of RK4 is safe for every damping, and not far too safe", "[methods][stability]") {
  const double lambda = 4e4;
  double tightest = 0;
  for (double damping = 1e-6; damping < 1e9; damping *= 1.5) {
    const double step_s = largest_stable_step_s(Method::rk4, lambda, damping);
    const auto growth = [&](double h_s) {
      const std::complex<double> root = std::sqrt(std::complex<double>(damping * damping / 4 - lambda));
      double most = 0;
      for (const double sign : {-1.0, 1.0}) {
        const std::complex<double> s =
            damping * damping > 4 * lambda && sign > 0 ? -lambda / (damping / 2 + root) : -damping / 2 + sign * root;
        const std::complex<double> z = h_s * s;
        most = std::max(most, std::abs(1.0 + z + z * z / 2.0 + z * z * z / 6.0 + z * z * z * z / 24.0));
      }
      return most;
    };
    INFO("damping " << damping << " /s, step " << step_s);
    for (double part = 1e-3; part <= 1; part *= 1.01) REQUIRE(growth(part * step_s) <= 1 + 1e-12);
    double edge = 1;
    while (growth(edge * step_s) <= 1 + 1e-12) edge *= 1.001;
    tightest = std::max(tightest, 1 / edge);
    CHECK(edge < 2.1);
  }
  CHECK(tightest > 0.9);
}

TEST_CASE("A damped oscillator of RK4 at its limit dies out over decades of damping", "[methods][stability][sweep]") {
  for (double damping_per_s = 1e-2; damping_per_s < 1e6; damping_per_s *= 10) {
    TissueScene pair = spring_pair();
    pair.method = Method::rk4;
    pair.damping_per_s = damping_per_s;
    pair.initial_displacement_m = {glm::dvec3(0), glm::dvec3(1e-5, 0, 0)};
    const auto solver =
        make_solver(SolverKind::cpu_double, scene_of(pair, std::floor(step_limit(pair).step_s * 1e9) * 1e-9));
    for (int n = 0; n < 1000; ++n) step(*solver, 1, {});
    CHECK(largest(*solver).first <= 1e-5 * (1 + 1e-9));
  }
}

TEST_CASE("OpenCL refuses the methods that it does not have, by name", "[methods]") {
  for (const auto& [method, name] :
       {std::pair{Method::rk4, "Runge-Kutta"}, std::pair{Method::implicit_midpoint, "implicit midpoint"},
        std::pair{Method::vertex_block_descent, "vertex block descent"}}) {
    TissueScene block = small_block();
    block.method = method;
    try {
      make_solver(SolverKind::opencl, scene_of(block, 1e-3));
      FAIL("not refused");
    } catch (const SolverError& error) {
      CHECK(error.fault() == SolverFault::unavailable);
      CHECK_THAT(error.what(), Catch::Contains(name) && Catch::Contains("opencl"));
    }
  }
}
