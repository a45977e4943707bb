// What a scene can have besides springs, compared with closed forms.
#include <glm/vector_relational.hpp>

#include "catch.h"
#include "feature_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// n particles along x. None is fixed and none is held.
TissueScene free_chain(int n) {
  TissueScene chain;
  chain.lattice = {n, 1, 1};
  chain.particle_count = n;
  chain.spacing_m = 0.01;
  chain.particle_mass_kg = 1e-3;
  chain.stiffness_N_per_m = 40;
  chain.fixed = FixedFaces::none();
  chain.substeps = 1;
  return chain;
}

/// A particle on one spring to a fixed one below it.
TissueScene oscillator() {
  TissueScene tissue = free_chain(1);
  tissue.lattice = {1, 1, 2};
  tissue.particle_count = 2;
  tissue.fixed.z_min = true;
  return tissue;
}

double apart_m(Solver& solver) {
  const auto u = solver.particle_state().displacement_m;
  return u[1].x - u[0].x;
}

const std::array kExplicit{Method::symplectic_euler, Method::velocity_verlet};

}  // namespace

TEST_CASE("A free block falls by g h^2 n (n + 1) / 2, by n^2 in velocity Verlet, whatever its materials",
          "[physics][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const Method method : kExplicit) {
      TissueScene block = featured_block({true, false, false, false, CouplingKind::grab, method});
      block.gravity_m_per_s2 = {0, 1.5, -9.81};
      block.fixed = FixedFaces::none();
      block.tools.clear();
      block.substeps = 2;
      const Scene scene = scene_of(block, 1e-3, true);
      const auto solver = make_solver(kind, scene);
      constexpr int kFallSteps = 100;
      for (int n = 0; n < kFallSteps; ++n) step(*solver, 0, {});
      const double h = period_s(scene.step_rate) / 2, n = 2 * kFallSteps;
      const double turns = method == Method::velocity_verlet ? n * n : n * (n + 1);
      // In 200 sums the g of the step keeps its rounding: at most 6e-8 on each side in float, 200 times 1e-16 in double.
      const double close = kind == SolverKind::cpu_double ? 1e-13 : 1e-5;
      for (const glm::dvec3& u : solver->particle_state().displacement_m) {
        REQUIRE(u.x == 0);
        REQUIRE(u.y == Approx(1.5 * h * h * turns / 2).epsilon(close));
        REQUIRE(u.z == Approx(-9.81 * h * h * turns / 2).epsilon(close));
      }
      CHECK(solver->verdict().energy_growth < 1e-4);  // the energy of motion does not count: it grows all the time
    }
  }
}

TEST_CASE("The tip of a hanging chain comes to rest m g n (n + 1) / (2 k) below its place", "[physics][sweep]") {
  for (const Method method : kExplicit) {
    for (const int n : {1, 2, 9}) {
      TissueScene chain;
      chain.lattice = {1, 1, n + 1};
      chain.particle_count = n + 1;
      chain.fixed = FixedFaces::none();
      chain.fixed.z_max = true;
      chain.damping_per_s = 60;
      chain.gravity_m_per_s2.z = -9.81;
      chain.method = method;
      const auto solver = make_solver(SolverKind::cpu_double, scene_of(chain, 5e-4));
      for (int s = 0; s < 4000; ++s) step(*solver, 0, {});  // exp(-60 / 2 * 2) of the fall is left
      const double stretch_m = chain.particle_mass_kg * 9.81 * n * (n + 1) / (2 * chain.stiffness_N_per_m);
      CHECK(solver->particle_state().displacement_m[0].z == Approx(-stretch_m).epsilon(1e-9));
    }
  }
}

// With w^2 = k (1/m1 + 1/m2) and 2 g = c (1/m1 + 1/m2) the distance y of two particles on a line follows
//   y_n+1 - (2 - 2 g h - w^2 h^2) y_n + (1 - 2 g h) y_n-1 = 0.
TEST_CASE("A pair's distance follows the discrete damped oscillator of its stiffnesses, masses and axial damper",
          "[physics][sweep]") {
  for (const Method method : kExplicit) {
    for (const double ratio : {1.0, 3.0, 1e6}) {
      for (const double axial : {0.0, 0.01, 0.05}) {
        TissueScene pair = free_chain(2);
        pair.method = method;
        pair.axial_damping_N_s_per_m = axial;
        pair.regions = {{{5e-3, -1, -1}, {1, 1, 1}, 100, ratio * pair.particle_mass_kg}};
        pair.initial_displacement_m = {glm::dvec3(-1e-4, 0, 0), glm::dvec3(0)};
        const double h = 1e-3, per_kg = 1 / pair.particle_mass_kg + 1 / (ratio * pair.particle_mass_kg);
        const double w2 = (pair.stiffness_N_per_m + 100) / 2 * per_kg, damping = axial * per_kg;
        const auto solver = make_solver(SolverKind::cpu_double, scene_of(pair, h));
        double before = apart_m(*solver), now = (step(*solver, 0, {}), apart_m(*solver));
        double largest = std::abs(before);
        for (int n = 0; n < 2000; ++n) {
          step(*solver, 0, {});
          const double next = apart_m(*solver);
          // Every force is rounded by 1e-16 of the spacing: 1e-16 * 0.01 m * w^2 h^2.
          REQUIRE(std::abs(next - (2 - damping * h - w2 * h * h) * now + (1 - damping * h) * before) < 1e-17);
          before = now, now = next;
          largest = std::max(largest, std::abs(now));
        }
        INFO("mass ratio " << ratio << ", axial damping " << axial);
        CHECK(largest < 1.5e-4);
        CHECK((std::abs(now) < 1e-5) == (axial > 0));
      }
    }
  }
}

TEST_CASE("Axial dampers and regions keep momentum and angular momentum, and take energy", "[physics]") {
  TissueScene block = featured_block({true, false, true, false});
  block.fixed = FixedFaces::none();
  block.tools.clear();
  for (int n = 0; n < block.particle_count; ++n) {
    const auto part = [&](int s) { return (n * s % 101) / 50.0 - 1; };
    block.initial_displacement_m.push_back(glm::dvec3(part(37), part(53), part(71)) * 2e-4);
    block.initial_velocity_m_per_s.push_back(glm::dvec3(part(29), part(83), part(59)) * 0.05);
  }
  block.substeps = 10;
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(block, 1e-3, true));
  const auto momenta = [&] {
    const ParticleState state = solver->particle_state();
    glm::dvec3 linear(0), angular(0);
    for (std::size_t n = 0; n < state.displacement_m.size(); ++n) {
      const int site = static_cast<int>(n);
      const glm::dvec3 rest_m = glm::dvec3(site % 6, site / 6 % 4, site / 24) * block.spacing_m;
      double mass_kg = block.particle_mass_kg;
      for (const MaterialRegion& region : block.regions) {
        if (rest_m.x >= region.min_m.x && rest_m.y >= region.min_m.y && rest_m.z >= region.min_m.z &&
            rest_m.x <= region.max_m.x && rest_m.z <= region.max_m.z)
          mass_kg = region.particle_mass_kg;
      }
      const glm::dvec3 x = rest_m + state.displacement_m[n], p = state.velocity_m_per_s[n] * mass_kg;
      linear += p;
      angular += glm::dvec3(x.y * p.z - x.z * p.y, x.z * p.x - x.x * p.z, x.x * p.y - x.y * p.x);
    }
    return std::pair{linear, angular};
  };
  const auto [linear, angular] = momenta();
  double energy_J = std::numeric_limits<double>::infinity();
  for (int n = 0; n < 200; ++n) {
    step(*solver, 0, {});
    REQUIRE(solver->verdict().energy_J < energy_J);
    energy_J = solver->verdict().energy_J;
  }
  const auto [linear_after, angular_after] = momenta();
  // 2000 substeps x 113 particles, with roundings of 1e-17 m/s * 1e-4 kg and random signs, make 5e-19. The angular momentum
  // has a lever of 25 mm in addition.
  CHECK(norm(linear_after - linear) < 1e-17);
  CHECK(norm(angular_after - angular) < 1e-18);
  CHECK(norm(linear) > 1e-6);
  CHECK(solver->verdict().energy_growth == 0);
}

TEST_CASE("Two masses keep their momentum at every ratio up to 10^12", "[physics][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const double ratio : {1.0, 1e3, 1e6, 1e9, 1e12}) {
      if (kind == SolverKind::opencl && ratio != 1e12) continue;
      TissueScene pair = free_chain(2);
      pair.regions = {{{5e-3, -1, -1}, {1, 1, 1}, pair.stiffness_N_per_m, ratio * pair.particle_mass_kg}};
      pair.initial_displacement_m = {glm::dvec3(-1e-3, 0, 0), glm::dvec3(0)};
      const auto solver = make_solver(kind, scene_of(pair, 1e-3));
      double largest = 0, speed = 0;
      for (int n = 0; n < 1000; ++n) {
        step(*solver, 0, {});
        const auto v = solver->particle_state().velocity_m_per_s;
        largest = std::max(largest, std::abs(v[0].x + ratio * v[1].x));
        speed = std::max(speed, std::abs(v[0].x));
      }
      INFO("mass ratio " << ratio);
      CHECK(largest < (kind == SolverKind::cpu_double ? 1e-13 : 1e-5) * speed);  // 1000 roundings
      CHECK(speed > 0.1);
    }
  }
}

TEST_CASE("A coupling in series with a spring feels k kc / (k + kc), and the weight that hangs from it",
          "[physics][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const Method method : kExplicit) {
      TissueScene tissue = oscillator();
      tissue.method = method;
      tissue.damping_per_s = 100;
      tissue.gravity_m_per_s2.z = -9.81;
      tissue.tools = {{glm::dvec3(0, 0, 0.01), 1e-3, CouplingKind::spring, 25, 0.05}};
      const auto solver = make_solver(kind, scene_of(tissue, 1e-3));
      step(*solver, 1, {});
      double force_N = 0;
      for (int n = 0; n < 1000; ++n) force_N = step(*solver, 1, {glm::dvec3(0, 0, 2e-3)}).force_N[0].z;
      // k u = kc (x - u) - m g, and the hand feels -kc (x - u).
      const double k = 40, kc = 25, weight_N = 1e-3 * 9.81, u = (kc * 2e-3 - weight_N) / (k + kc);
      CHECK(force_N == Approx(-kc * (2e-3 - u)).epsilon(kind == SolverKind::cpu_double ? 1e-10 : 1e-5));
    }
  }
}

TEST_CASE("A coupled particle follows its recurrence in long double while the hand moves", "[physics]") {
  for (const int substeps : {1, 3}) {
    TissueScene tissue = oscillator();
    tissue.substeps = substeps;
    tissue.tools = {{glm::dvec3(0, 0, 0.01), 1e-3, CouplingKind::spring, 25, 0.05}};
    const Scene scene = scene_of(tissue, 1e-3);
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    step(*solver, 1, {});
    const long double h = static_cast<long double>(period_s(scene.step_rate)) / substeps;
    const long double m = 1e-3, k = 40, kc = 25, b = 0.05;
    long double u = 0, v = 0, x = 0, w = 0;
    for (int n = 1; n <= 500; ++n) {
      const double target_m = 1e-3 * (n % 100) / 50.0 - 5e-4 * (n / 300);
      const long double from = x;
      for (int s = 1; s <= substeps; ++s) {
        v += h / m * (kc * (x - u) + b * (w - v) - k * u);
        u += h * v;
        x = from + (target_m - from) * s / substeps;
        w = (target_m - from) / (h * substeps);
      }
      const double force_N = step(*solver, 1, {glm::dvec3(0, 0, target_m)}).force_N[0].z;
      REQUIRE(std::abs(force_N + static_cast<double>(kc * (x - u) + b * (w - v))) < 1e-12);  // jumps of 2 m/s: 0.1 N
    }
  }
}

TEST_CASE("A particle leaves a probe as fast as it came, and is never pulled", "[physics][sweep]") {
  for (const SolverKind kind : kEverySolver) {
    for (const Method method : kExplicit) {
      for (const double wh : {0.01, 0.05, 0.2}) {
        if (kind == SolverKind::opencl && wh != 0.2) continue;  // each costs a compilation
        TissueScene ball = free_chain(1);
        ball.method = method;
        const double w_per_s = 200, speed_m_per_s = 0.1, radius_m = 0.02;
        ball.tools = {{glm::dvec3(0.025, 0, 0), radius_m, CouplingKind::probe, ball.particle_mass_kg * w_per_s * w_per_s}};
        ball.initial_velocity_m_per_s = {glm::dvec3(speed_m_per_s, 0, 0)};
        Scene scene = scene_of(ball, wh / w_per_s, true);
        scene.local_model = LocalModel::instantaneous;
        const auto solver = make_solver(kind, scene);
        double most_N = 0;
        for (int n = 0; n < 25 / wh; ++n) {  // 10 to the sphere, pi in it, and out again
          const ToolResponse response = step(*solver, 1, {});
          REQUIRE(response.force_N[0].x >= 0);  // the hand is pushed away
          REQUIRE(solver->contacts()[0].touching == (response.force_N[0].x > 0));
          most_N = std::max(most_N, response.force_N[0].x);
        }
        INFO("w h = " << wh);
        // Inside, v^2 + w^2 q^2 - h w^2 v q stays; at the edge q is up to h v: (w h)^2.
        CHECK(solver->particle_state().velocity_m_per_s[0].x == Approx(-speed_m_per_s).epsilon(wh * wh + 1e-5));
        CHECK(most_N == Approx(speed_m_per_s * w_per_s * ball.particle_mass_kg).epsilon(wh));  // v sqrt(K m)
        CHECK(solver->verdict().energy_growth < wh);
      }
    }
  }
}

TEST_CASE("A particle at the very centre of a probe has no direction and feels nothing", "[physics]") {
  for (const SolverKind kind : kEverySolver) {
    TissueScene ball = free_chain(1);
    ball.tools = {{glm::dvec3(0), 0.02, CouplingKind::probe, 10}};
    Scene scene = scene_of(ball, 1e-3, true);
    scene.local_model = LocalModel::settled;
    const auto solver = make_solver(kind, scene);
    for (int n = 0; n < 10; ++n) {
      const ToolResponse response = step(*solver, 1, {});
      CHECK(response.force_N[0] == glm::dvec3(0));
      CHECK(solver->contacts()[0].touching);
      CHECK(solver->contacts()[0].stiffness_N_per_m == glm::dmat3(0));
      CHECK(solver->contacts()[0].gap_m == Approx(-0.02));
    }
    CHECK_FALSE(solver->verdict().non_finite);
  }
}

TEST_CASE("Symplectic Euler has order 1 and velocity Verlet order 2", "[physics][sweep]") {
  for (const Method method : kExplicit) {
    const auto error_m = [&](double h) {
      TissueScene pair = free_chain(2);
      pair.method = method;
      pair.initial_displacement_m = {glm::dvec3(-1e-4, 0, 0), glm::dvec3(1e-4, 0, 0)};
      const Scene scene = scene_of(pair, h);
      const auto solver = make_solver(SolverKind::cpu_double, scene);
      const int steps = static_cast<int>(std::lround(0.08 / h));
      for (int n = 0; n < steps; ++n) step(*solver, 0, {});
      const double w_per_s = std::sqrt(2 * pair.stiffness_N_per_m / pair.particle_mass_kg);
      return std::abs(apart_m(*solver) - 2e-4 * std::cos(w_per_s * period_s(scene.step_rate) * steps));
    };
    for (const double h : {1e-4, 5e-5, 2.5e-5}) {
      const double order = std::log2(error_m(h) / error_m(h / 2));
      CHECK(order == Approx(method == Method::velocity_verlet ? 2 : 1).margin(0.05));
    }
  }
}

// V is symplectic Euler's velocity, half a step before u. Verlet starts at v with v + h a(u, v)/2 = V + h a(u, V).
TEST_CASE("Velocity Verlet takes symplectic Euler's path with the velocity half a step aside, with everything",
          "[physics]") {
  for (const double damping_per_s : {0.0, 30.0}) {
    TissueScene block = featured_block({true, false, false, true, CouplingKind::spring});
    block.damping_per_s = damping_per_s;
    block.tools[0].damping_N_s_per_m = 0;
    block.substeps = 1;
    for (int n = 0; n < block.particle_count; ++n) {
      const auto part = [&](int s) { return (n * s % 101) / 50.0 - 1; };
      block.initial_displacement_m.push_back(glm::dvec3(part(37), part(53), part(71)) * 2e-4);
      block.initial_velocity_m_per_s.push_back(glm::dvec3(part(29), part(83), part(59)) * 0.05);
    }
    const Scene scene = scene_of(block, 2e-4);
    // What a step leaves of the velocity of site n, whose mass is that of the last region it lies in.
    const auto kept_of = [&](std::size_t n) {
      const auto [nx, ny, nz] = block.lattice;
      const auto site = static_cast<int>(n);
      const glm::dvec3 at_m = glm::dvec3(site % nx, site / nx % ny, site / nx / ny) * block.spacing_m;
      double mass_kg = block.particle_mass_kg;
      for (const MaterialRegion& region : block.regions) {
        if (glm::all(glm::greaterThanEqual(at_m, region.min_m)) && glm::all(glm::lessThanEqual(at_m, region.max_m)))
          mass_kg = region.particle_mass_kg;
      }
      return 1 - period_s(scene.step_rate) * damping_per_s * block.particle_mass_kg / mass_kg;
    };
    const auto euler = make_solver(SolverKind::cpu_double, scene);
    const ParticleState before = euler->particle_state();
    step(*euler, 2, wandering_tools(0));
    const ParticleState after = euler->particle_state();
    TissueScene verlet_block = block;
    verlet_block.method = Method::velocity_verlet;
    for (std::size_t n = 0; n < before.velocity_m_per_s.size(); ++n) {
      const double kept = kept_of(n);
      const glm::dvec3 decayed = before.velocity_m_per_s[n] * kept;
      verlet_block.initial_velocity_m_per_s[n] = (decayed + (after.velocity_m_per_s[n] - decayed) * 0.5) / ((1 + kept) / 2);
    }
    const auto verlet = make_solver(SolverKind::cpu_double, scene_of(verlet_block, 2e-4));
    step(*verlet, 2, wandering_tools(0));
    for (int n = 1; n < 100; ++n) {
      const ToolResponse a = step(*euler, 2, wandering_tools(n)), b = step(*verlet, 2, wandering_tools(n));
      const auto u = euler->particle_state().displacement_m, w = verlet->particle_state().displacement_m;
      for (std::size_t i = 0; i < u.size(); ++i) REQUIRE(norm(u[i] - w[i]) < 1e-13);  // roundings of 1e-18 m, 100 steps
      for (std::size_t tool = 0; tool < 2; ++tool) REQUIRE(norm(a.force_N[tool] - b.force_N[tool]) < 1e-10);
    }
  }
}

TEST_CASE("The initial velocity of a fixed particle counts for nothing: a fixed face drags no damper", "[physics]") {
  for (const SolverKind kind : kEverySolver) {
    TissueScene block = featured_block({false, false, true, false, CouplingKind::spring});
    const auto count = static_cast<std::size_t>(block.particle_count), fixed = std::size_t{6 * 4};  // the bottom layer
    block.initial_velocity_m_per_s.assign(count, glm::dvec3(0.02, -0.01, 0.03));
    const auto moving = make_solver(kind, scene_of(block, 1e-3));
    std::fill_n(block.initial_velocity_m_per_s.begin(), fixed, glm::dvec3(0));
    const auto still = make_solver(kind, scene_of(block, 1e-3));
    for (int n = 0; n < 20; ++n) {
      REQUIRE(same_bits(step(*moving, 2, wandering_tools(n)), step(*still, 2, wandering_tools(n))));
      const ParticleState state = moving->particle_state();
      for (std::size_t i = 0; i < fixed; ++i) {
        REQUIRE(state.velocity_m_per_s[i] == glm::dvec3(0));
        REQUIRE(state.displacement_m[i] == glm::dvec3(0));
      }
    }
  }
}

TEST_CASE("A coupling holds the particle that lies exactly on its radius, and not the next", "[physics]") {
  for (const CouplingKind kind : {CouplingKind::grab, CouplingKind::spring}) {
    TissueScene row;
    row.lattice = {4, 1, 1};
    row.particle_count = 4;
    row.spacing_m = 0.0078125;  // 2^-7: distances are exact
    row.fixed = FixedFaces::none();
    row.tools = {{glm::dvec3(row.spacing_m, 0, 0), row.spacing_m, kind, kind == CouplingKind::grab ? 0.0 : 30.0}};
    const auto solver = make_solver(SolverKind::cpu_double, scene_of(row, 1e-4));
    step(*solver, 1, {});
    for (int n = 0; n < 2; ++n) step(*solver, 1, {glm::dvec3(1e-4, 0, 0)});  // a spring pulls from the second on
    const ParticleState state = solver->particle_state();
    // Particles 0, 1 and 2 are taken along alike, by the tool or by a third of its spring each; particle 3 is pulled later.
    const auto moved_m = [&](std::size_t i) { return state.displacement_m[i].x; };
    CHECK(moved_m(1) > 0);
    CHECK(moved_m(0) == moved_m(1));
    CHECK(moved_m(2) == moved_m(1));
    CHECK(moved_m(3) < 0.1 * moved_m(1));
  }
}
