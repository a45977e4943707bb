// The methods other than symplectic Euler, compared with what they must compute in closed form.
#include <functional>
#include <numbers>

#include "../tissue_scenes.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::array kMethods{Method::rk4, Method::implicit_euler, Method::implicit_midpoint, Method::vertex_block_descent};

using Real = long double;
/// A matrix for the linear system y' = A y with y = (u, v).
struct Matrix {
  Real a, b, c, d;
  friend Matrix operator*(const Matrix& m, const Matrix& n) {
    return {m.a * n.a + m.b * n.c, m.a * n.b + m.b * n.d, m.c * n.a + m.d * n.c, m.c * n.b + m.d * n.d};
  }
  friend Matrix operator+(const Matrix& m, const Matrix& n) { return {m.a + n.a, m.b + n.b, m.c + n.c, m.d + n.d}; }
  friend Matrix operator*(Real s, const Matrix& m) { return {s * m.a, s * m.b, s * m.c, s * m.d}; }
  Matrix inverse() const {
    const Real det = a * d - b * c;
    return {d / det, -b / det, -c / det, a / det};
  }
};

/// The matrix R(A) by which the method advances y in one step of length 1.
Matrix amplification(Method method, const Matrix& a) {
  const Matrix one{1, 0, 0, 1};
  switch (method) {
    case Method::rk4:
      return one + a + Real{1} / 2 * (a * a) + Real{1} / 6 * (a * a * a) + Real{1} / 24 * (a * a * a * a);
    case Method::implicit_midpoint:
      return (one + Real{-0.5} * a).inverse() * (one + Real{0.5} * a);
    default:
      return (one + Real{-1} * a).inverse();
  }
}

/// 64 free particles between two fixed ones; exactly linear along the chain.
TissueScene chain() {
  TissueScene tissue;
  tissue.lattice = {66, 1, 1};
  tissue.particle_count = 66;
  tissue.fixed = {true, true, false, false, false, false};
  tissue.substeps = 1;
  return tissue;
}
constexpr int kFree = 64;

/// The sum of modes 1 to 3 at time t, released at rest, with w_p = 2 sqrt(k / m) sin(p pi / (2 (n + 1))).
std::vector<glm::dvec3> modes(const TissueScene& scene, double t_s) {
  std::vector<glm::dvec3> u(66, glm::dvec3(0));
  for (int p = 1; p <= 3; ++p) {
    const double turn = p * std::numbers::pi / (kFree + 1);
    const double w_per_s = 2 * std::sqrt(scene.stiffness_N_per_m / scene.particle_mass_kg) * std::sin(turn / 2);
    for (int i = 1; i <= kFree; ++i)
      u[static_cast<std::size_t>(i)].x += 1e-3 / p * std::cos(w_per_s * t_s) * std::sin(turn * i);
  }
  return u;
}

/// The largest distance from the closed form after 0.25 s, divided by the amplitude.
double chain_error(Method method, double step_s, int iterations) {
  TissueScene scene = chain();
  scene.method = method;
  scene.iterations = iterations;
  scene.initial_displacement_m = modes(scene, 0);
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(scene, step_s));
  const int steps = static_cast<int>(std::llround(0.25 / step_s));
  for (int n = 0; n < steps; ++n) step(*solver, 0, {});
  const ParticleState state = solver->particle_state();
  const auto exact = modes(scene, 0.25);
  double worst = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) worst = std::max(worst, norm(state.displacement_m[i] - exact[i]));
  return worst / 1e-3;
}

}  // namespace

TEST_CASE("A free particle on a spring follows each method's amplification matrix, damped or not, at any w h",
          "[methods][sweep]") {
  for (const Method method : kMethods) {
    for (const double wh : {1e-3, 0.1, 0.5, 1.0, 1.9, 2.6, 30.0, 1e4}) {
      if (method == Method::rk4 && wh > 2.7) continue;
      for (const double damping_h : {0.0, 0.01, 0.3}) {
        TissueScene pair = spring_pair();
        pair.method = method;
        pair.damping_per_s = damping_h / 1e-3;
        pair.stiffness_N_per_m = wh * wh / 1e-6 * pair.particle_mass_kg;
        pair.initial_displacement_m = {glm::dvec3(0), glm::dvec3(1e-3, 0, 0)};
        pair.initial_velocity_m_per_s = {glm::dvec3(0), glm::dvec3(0.2, 0, 0)};
        Scene scene = scene_of(pair, 1e-3);
        scene.allow_unstable = true;  // the limit is for two free particles
        const auto solver = make_solver(SolverKind::cpu_double, scene);
        const Real h = 1e-3L, k_per_m = static_cast<Real>(pair.stiffness_N_per_m) / pair.particle_mass_kg;
        const Matrix step_matrix = amplification(method, {0, h, -h * k_per_m, -h * pair.damping_per_s});
        Real u = 1e-3L, v = 0.2L, largest_u = 1e-3L, largest_v = 0.2L;
        for (int n = 0; n < 200; ++n) {
          step(*solver, 1, {});
          std::tie(u, v) = std::pair(step_matrix.a * u + step_matrix.b * v, step_matrix.c * u + step_matrix.d * v);
          largest_u = std::max(largest_u, std::abs(u)), largest_v = std::max(largest_v, std::abs(v));
        }
        const ParticleState state = solver->particle_state();
        INFO("method " << static_cast<int>(method) << ", w h = " << wh << ", damping h = " << damping_h);
        // Each of 200 steps rounds the vector of the spring to 1e-16 of the spacing (1e-15 of the amplitude).
        CHECK(std::abs(state.displacement_m[1].x - u) < 1e-12L * largest_u);
        CHECK(std::abs(state.velocity_m_per_s[1].x - v) < 1e-12L * std::max(largest_v, largest_u * 1000));
        CHECK(state.displacement_m[1].y == 0);
      }
    }
  }
}

TEST_CASE("The tool moves in a straight line within a substep, and each method sees it at its own times", "[methods]") {
  for (const Method method : kMethods) {
    for (const int substeps : {1, 3}) {
      TissueScene pair = spring_pair();
      pair.method = method;
      pair.damping_per_s = 20;
      pair.substeps = substeps;
      const auto solver = make_solver(SolverKind::cpu_double, scene_of(pair, 2e-3));
      const Real h = 2e-3L / substeps, k_per_m = static_cast<Real>(pair.stiffness_N_per_m) / pair.particle_mass_kg, d = 20;
      Real u = 0, v = 0, tool = 0, worst_N = 0;
      const auto a = [&](Real at, Real speed, Real held_at) { return k_per_m * (held_at - at) - d * speed; };
      step(*solver, 1, {});
      for (int n = 1; n <= 300; ++n) {
        const double target_m = 1e-3 * (n % 100) / 50.0 - 5e-4 * (n / 200);
        const Real from = tool;
        for (int s = 1; s <= substeps; ++s) {
          const Real to = from + (target_m - from) * s / substeps, middle = (tool + to) / 2;
          if (method == Method::rk4) {
            const Real u1 = v, v1 = a(u, v, tool), u2 = v + h / 2 * v1, v2 = a(u + h / 2 * u1, v + h / 2 * v1, middle);
            const Real u3 = v + h / 2 * v2, v3 = a(u + h / 2 * u2, v + h / 2 * v2, middle);
            const Real u4 = v + h * v3, v4 = a(u + h * u3, v + h * v3, to);
            u += h / 6 * (u1 + 2 * u2 + 2 * u3 + u4);
            v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
          } else if (method == Method::implicit_midpoint) {
            const Real x = (v + h / 2 * k_per_m * (middle - u)) / (1 + h / 2 * d + h * h / 4 * k_per_m);
            u += h * x;
            v = 2 * x - v;
          } else {
            v = (v + h * k_per_m * (to - u)) / (1 + h * d + h * h * k_per_m);
            u += h * v;
          }
          tool = to;
        }
        const double force_N = step(*solver, 1, {glm::dvec3(target_m, 0, 0)}).force_N[0].x;
        worst_N = std::max(worst_N, std::abs(force_N - static_cast<Real>(pair.stiffness_N_per_m) * (u - tool)));
      }
      INFO("method " << static_cast<int>(method) << ", substeps " << substeps);
      CHECK(worst_N < 1e-12L);  // as for symplectic Euler: 1e-16 of the spacing in each of 900 substeps
    }
  }
}

TEST_CASE("A particle on a tool's spring and damper follows each method's recurrence while the tool moves", "[methods]") {
  const Real m = 1e-3L, kc = 25, b = 0.05L;
  for (const Method method : {Method::rk4, Method::implicit_euler, Method::implicit_midpoint}) {
    for (const int substeps : {1, 3}) {
      TissueScene ball;
      ball.lattice = {1, 1, 1};
      ball.particle_count = 1;
      ball.fixed = FixedFaces::none();
      ball.particle_mass_kg = 1e-3;
      ball.method = method;
      ball.substeps = substeps;
      ball.tools = {{glm::dvec3(0), 1e-3, CouplingKind::spring, 25, 0.05}};
      const auto solver = make_solver(SolverKind::cpu_double, scene_of(ball, 2e-3));
      const Real h = 2e-3L / substeps;
      Real u = 0, v = 0, tool = 0, worst_N = 0;
      step(*solver, 1, {});
      for (int n = 1; n <= 300; ++n) {
        const double target_m = 1e-3 * (n % 100) / 50.0 - 5e-4 * (n / 200);
        const Real from = tool, w = (target_m - from) / (h * substeps);
        const auto a = [&](Real at, Real speed, Real held_at) { return (kc * (held_at - at) + b * (w - speed)) / m; };
        for (int s = 1; s <= substeps; ++s) {
          const Real to = from + (target_m - from) * s / substeps, middle = (tool + to) / 2;
          if (method == Method::rk4) {
            const Real u1 = v, v1 = a(u, v, tool), u2 = v + h / 2 * v1, v2 = a(u + h / 2 * u1, v + h / 2 * v1, middle);
            const Real u3 = v + h / 2 * v2, v3 = a(u + h / 2 * u2, v + h / 2 * v2, middle);
            const Real u4 = v + h * v3, v4 = a(u + h * u3, v + h * v3, to);
            u += h / 6 * (u1 + 2 * u2 + 2 * u3 + u4);
            v += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
          } else if (method == Method::implicit_midpoint) {
            // x is the velocity in the middle of the substep, where the force is taken.
            const Real x = (v + h / 2 * a(u, 0, middle)) / (1 + h / 2 * b / m + h * h / 4 * kc / m);
            u += h * x;
            v = 2 * x - v;
          } else {
            v = (v + h * a(u, 0, to)) / (1 + h * b / m + h * h * kc / m);
            u += h * v;
          }
          tool = to;
        }
        const double force_N = step(*solver, 1, {glm::dvec3(target_m, 0, 0)}).force_N[0].x;
        worst_N = std::max(worst_N, std::abs(force_N + kc * (tool - u) + b * (w - v)));
      }
      INFO("method " << static_cast<int>(method) << ", substeps " << substeps);
      CHECK(worst_N < 1e-12L);  // 900 substeps round forces of up to 0.1 N by 1e-17 N each
    }
  }
}

TEST_CASE("A particle on a fixed one's spring and axial damper follows each implicit method's recurrence, at any step",
          "[methods]") {
  const Real m = 1e-3L, k = 40, c = 0.05L;
  for (const Method method : {Method::implicit_euler, Method::implicit_midpoint, Method::vertex_block_descent}) {
    for (const Real h : {1e-4L, 1e-3L, 2e-2L}) {
      TissueScene pair;
      pair.lattice = {2, 1, 1};
      pair.particle_count = 2;
      pair.spacing_m = 0.01;
      pair.fixed = FixedFaces::none();
      pair.fixed.x_min = true;
      pair.particle_mass_kg = 1e-3;
      pair.stiffness_N_per_m = 40;
      pair.axial_damping_N_s_per_m = 0.05;
      pair.method = method;
      pair.substeps = 1;
      pair.initial_displacement_m = {glm::dvec3(0), glm::dvec3(1e-3, 0, 0)};
      pair.initial_velocity_m_per_s = {glm::dvec3(0), glm::dvec3(0.1, 0, 0)};
      const auto solver = make_solver(SolverKind::cpu_double, scene_of(pair, static_cast<double>(h)));
      Real u = 1e-3L, v = 0.1L, worst_m = 0;
      const Real q = method == Method::implicit_midpoint ? h / 2 : h;  // where the force is taken
      for (int n = 0; n < 100; ++n) {
        const Real x = (v - q * k / m * u) / (1 + q * c / m + q * q * k / m);
        u += h * x;
        v = method == Method::implicit_midpoint ? 2 * x - v : x;
        step(*solver, 0, {});
        worst_m = std::max(worst_m, std::abs(solver->particle_state().displacement_m[1].x - u));
      }
      INFO("method " << static_cast<int>(method) << ", h " << h);
      CHECK(worst_m < 1e-14L);  // 100 steps round the vector of the spring to 1e-18 m each
    }
  }
}

TEST_CASE("The observed order on a chain is 4 for RK4, 2 for implicit midpoint, 1 for the implicit Euler methods",
          "[methods][sweep]") {
  struct Case {
    Method method;
    double order, tolerance, step_s;
    int iterations;
  };
  // With these steps the leading term dominates and rounding does not. The damping w^2 h T / 2 of implicit Euler is at most
  // 0.03.
  for (const auto& [method, order, tolerance, step_s, iterations] :
       {Case{Method::rk4, 4, 0.1, 1e-3, 0}, Case{Method::implicit_midpoint, 2, 0.05, 1e-3, 80},
        Case{Method::implicit_euler, 1, 0.05, 31.25e-6, 8}, Case{Method::vertex_block_descent, 1, 0.05, 31.25e-6, 6}}) {
    double before = chain_error(method, step_s, iterations);
    for (const int finer : {2, 4}) {
      const double error = chain_error(method, step_s / finer, iterations);
      INFO("method " << static_cast<int>(method) << ", step " << step_s / finer << " s, error " << error);
      CHECK(std::log2(before / error) == Approx(order).margin(tolerance));
      before = error;
    }
  }
}

TEST_CASE("Implicit Euler leaves 1 / (1 + w^2 h^2) of a mode's energy per step, implicit midpoint all of it for 10 s",
          "[methods][sweep]") {
  for (const double wh : {1e-2, 1.0, 3.2, 32.0, 1e4}) {
    TissueScene pair = spring_pair();
    pair.stiffness_N_per_m = wh * wh / 1e-6 * pair.particle_mass_kg;
    pair.initial_displacement_m = {glm::dvec3(0), glm::dvec3(1e-3, 0, 0)};
    pair.iterations = 4;  // with one unknown the first iteration is exact
    const double start_J = pair.stiffness_N_per_m * 1e-6 / 2;
    INFO("w h = " << wh);
    pair.method = Method::implicit_euler;
    const auto euler = make_solver(SolverKind::cpu_double, scene_of(pair, 1e-3, true));
    double expected_J = start_J;
    for (int n = 0; n < 3; ++n) {
      step(*euler, 1, {});
      expected_J /= 1 + wh * wh;
      // The stretch of the spring is known to 1e-18 m, so the energy is known to k (1e-18)^2 and 1e-15 of the amplitude.
      CHECK(euler->verdict().energy_J == Approx(expected_J).epsilon(1e-10).margin(start_J * 1e-14));
    }
    pair.method = Method::implicit_midpoint;
    const auto midpoint = make_solver(SolverKind::cpu_double, scene_of(pair, 1e-3, true));
    double worst = 0;
    for (int n = 0; n < 10'000; ++n) {
      step(*midpoint, 1, {});
      worst = std::max(worst, std::abs(midpoint->verdict().energy_J / start_J - 1));
    }
    CHECK(worst < 1e-9);
  }
}
