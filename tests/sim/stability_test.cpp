
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Spring {
  std::size_t a, b;
  glm::dvec3 direction;
};

/// The graph, made independently of the solver: it joins sites at distance 1 or sqrt(2).
std::vector<Spring> springs_of(const TissueScene& scene) {
  const auto [nx, ny, nz] = scene.lattice;
  std::vector<Spring> springs;
  const auto site = [width = nx, height = ny](int x, int y, int z) {
    return x + static_cast<std::int64_t>(width) * (y + static_cast<std::int64_t>(height) * z);
  };
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        for (int dz = 0; dz <= 1; ++dz)
          for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
              const int distance2 = dx * dx + dy * dy + dz * dz;
              if (distance2 != 1 && distance2 != 2) continue;
              if (dz == 0 && (dy < 0 || (dy == 0 && dx < 0))) continue;  // every pair once
              const int u = x + dx, v = y + dy, w = z + dz;
              if (u < 0 || u >= nx || v < 0 || v >= ny || w >= nz) continue;
              const std::int64_t i = site(x, y, z), j = site(u, v, w);
              if (i >= scene.particle_count || j >= scene.particle_count) continue;
              springs.push_back(
                  {static_cast<std::size_t>(i), static_cast<std::size_t>(j), glm::dvec3(dx, dy, dz) / std::sqrt(distance2)});
            }
      }
  return springs;
}

/// The largest eigenvalue by power iteration. It is found from below, because a Rayleigh quotient never exceeds it.
template <class Apply>
double power_iteration(std::size_t size, int rounds, Apply apply) {
  std::vector<double> x(size), y(size);
  for (std::size_t i = 0; i < size; ++i) x[i] = (i * 2654435761u % 1000) / 500.0 - 1;
  double lambda = 0;
  for (int n = 0; n < rounds; ++n) {
    std::fill(y.begin(), y.end(), 0);
    apply(x, y);
    double xy = 0, xx = 0, yy = 0;
    for (std::size_t i = 0; i < size; ++i) xy += x[i] * y[i], xx += x[i] * x[i], yy += y[i] * y[i];
    lambda = xy / xx;
    for (std::size_t i = 0; i < size; ++i) x[i] = y[i] / std::sqrt(yy);
  }
  return lambda;
}

double scalar_laplacian(const TissueScene& scene, int rounds) {
  const auto springs = springs_of(scene);
  const auto fixed = static_cast<std::size_t>(scene.fixed.z_min ? scene.lattice[0] * scene.lattice[1] : 0);
  return power_iteration(static_cast<std::size_t>(scene.particle_count), rounds, [&](const auto& x, auto& y) {
    for (const auto& [a, b, direction] : springs) y[a] += x[a] - x[b], y[b] += x[b] - x[a];
    std::fill(y.begin(), y.begin() + static_cast<std::ptrdiff_t>(fixed), 0);
  });
}

/// The largest eigenvalue at rest, where springs resist only along themselves.
double rest_state_hessian(const TissueScene& scene, int rounds) {
  const auto springs = springs_of(scene);
  return power_iteration(3 * static_cast<std::size_t>(scene.particle_count), rounds, [&](const auto& x, auto& y) {
    for (const auto& [a, b, d] : springs) {
      const double along =
          d.x * (x[3 * a] - x[3 * b]) + d.y * (x[3 * a + 1] - x[3 * b + 1]) + d.z * (x[3 * a + 2] - x[3 * b + 2]);
      for (int axis = 0; axis < 3; ++axis) {
        y[3 * a + static_cast<std::size_t>(axis)] += d[axis] * along;
        y[3 * b + static_cast<std::size_t>(axis)] -= d[axis] * along;
      }
    }
  });
}

TissueScene cut_block(std::array<int, 3> lattice, int left_out, bool fixed) {
  TissueScene scene;
  scene.lattice = lattice;
  scene.particle_count = static_cast<std::int64_t>(lattice[0]) * lattice[1] * lattice[2] - left_out;
  scene.fixed.z_min = fixed;
  return scene;
}

}  // namespace

TEST_CASE("The limit's lambda bounds the spring graph of every small cut block and is nearly reached by a large one",
          "[stability]") {
  double tightest = 0;
  int blocks = 0;
  for (int nx = 2; nx <= 5; ++nx)
    for (int ny = 2; ny <= 5; ++ny)
      for (int nz = 2; nz <= 5; ++nz) {
        for (const bool fixed : {false, true})
          for (const int left_out : {0, 1, nx * ny / 2, nx * ny - 1}) {
            const TissueScene scene = cut_block({nx, ny, nz}, left_out, fixed);
            const double k_per_m = scene.stiffness_N_per_m / scene.particle_mass_kg;
            const double bound = step_limit(scene).lambda_per_s2 / k_per_m, lambda = scalar_laplacian(scene, 60);
            REQUIRE(lambda <= bound * (1 + 1e-12));
            REQUIRE(bound <= 24 * (1 + 1e-13));
            tightest = std::max(tightest, lambda / bound);
            ++blocks;
          }
      }
  CHECK(blocks == 512);
  CHECK(tightest > 0.85);
  const TissueScene large = cut_block({14, 13, 15}, 100, true);
  CHECK(scalar_laplacian(large, 300) > 23.2);  // only an infinite lattice reaches 24
  CHECK(scalar_laplacian(large, 300) < 24);
}

TEST_CASE("At rest the largest eigenvalue stays below 12 k/m", "[stability]") {
  for (const auto& scene :
       {cut_block({2, 2, 2}, 0, false), cut_block({7, 5, 6}, 9, false), cut_block({12, 12, 12}, 30, false)}) {
    CHECK(rest_state_hessian(scene, 200) < 12);
  }
  CHECK(rest_state_hessian(cut_block({12, 12, 12}, 30, false), 400) > 11.5);
}

TEST_CASE("The limit solves h^2 lambda + 2 h d = 4 for every damping, and rest is laxer by sqrt(2)", "[stability]") {
  TissueScene block = small_block();
  CHECK(step_limit(block).step_s ==
        Approx(std::sqrt(block.particle_mass_kg / (6 * block.stiffness_N_per_m))).epsilon(1e-14));
  CHECK(step_limit(block).rest_state_step_s ==
        Approx(std::sqrt(block.particle_mass_kg / (3 * block.stiffness_N_per_m))).epsilon(1e-14));
  for (double damping = 1e-6; damping < 1e12; damping *= 10) {
    block.damping_per_s = damping;
    const StepLimit limit = step_limit(block);
    CHECK(limit.step_s * limit.step_s * limit.lambda_per_s2 + 2 * limit.step_s * damping == Approx(4).epsilon(1e-13));
  }
}

TEST_CASE("Automatic substeps are the least that keep the safety margin", "[stability]") {
  for (double stiffness = 1e-2; stiffness < 1e8; stiffness *= 3.7) {
    for (const Rate rate : {Rate{450, 1}, Rate{1000, 1}, Rate{30'000, 1001}}) {
      TissueScene block = small_block();
      block.stiffness_N_per_m = stiffness;
      const int n = auto_substeps(block, rate);
      const double longest_s = kStepSafety * step_limit(block).step_s;
      REQUIRE(period_s(rate) / n <= longest_s * (1 + 1e-12));
      if (n > 1) REQUIRE(period_s(rate) / (n - 1) > longest_s * (1 - 1e-12));
      if (stiffness < 1e3)
        REQUIRE(make_solver(SolverKind::cpu_double,
                            [&] {
                              Scene s = scene_of(block, 0.1);
                              s.step_rate = rate;
                              return s;
                            }())
                    ->info()
                    .substeps == n);
    }
  }
  TissueScene stiff = small_block();
  stiff.stiffness_N_per_m = 1e14;
  CHECK_THROWS_AS(auto_substeps(stiff, {450, 1}), SolverError);
}

// The block is pulled to three times its length. There, springs resist across the pull, too, like k (1 - L/len), so modes
// that were soft at rest are stiff.
TEST_CASE("A stretched block is stable up to the limit and diverges at steps that the rest-state limit calls stable",
          "[stability]") {
  TissueScene block;
  block.lattice = {6, 6, 8};
  block.particle_count = 6 * 6 * 8;
  block.particle_mass_kg = 1e-4;
  block.stiffness_N_per_m = 20;
  block.substeps = 1;
  const double a = block.spacing_m;
  block.tools = {{glm::dvec3(2.5, 2.5, 1007) * a, 1000.1 * a}};  // the top layer
  const auto survives = [&](double step_s) {
    Scene scene = scene_of(block, step_s);
    scene.allow_unstable = true;
    const auto solver = make_solver(SolverKind::cpu_double, scene);
    const int pull = static_cast<int>(0.5 / step_s);  // half a second
    for (int n = 0; n < 3 * pull && !solver->verdict().non_finite; ++n) {
      step(*solver, 1, {glm::dvec3(0, 0, 14 * a * std::min(1.0, static_cast<double>(n) / pull))});
    }
    return !solver->verdict().non_finite;
  };
  const StepLimit limit = step_limit(block);
  CHECK(limit.step_s == Approx(0.913e-3).epsilon(1e-3));
  CHECK(limit.rest_state_step_s == Approx(1.291e-3).epsilon(1e-3));
  for (const double step_s : {0.8 * limit.step_s, 0.999 * limit.step_s}) CHECK(survives(step_s));
  for (const double step_s : {1.15e-3, 0.99 * limit.rest_state_step_s}) CHECK_FALSE(survives(step_s));
}

TEST_CASE("Unstable substeps are refused with the limit and the remedy, unless asked for", "[stability]") {
  TissueScene block = small_block();
  block.substeps = 2;
  const double limit_s = step_limit(block).step_s;
  CHECK_NOTHROW(make_solver(SolverKind::cpu_float, scene_of(block, 2 * limit_s * 0.9999)));
  for (const SolverKind kind : kEverySolver) {
    Scene scene = scene_of(block, 2 * limit_s * 1.0001);
    try {
      make_solver(kind, scene);
      FAIL("not refused");
    } catch (const SolverError& error) {
      CHECK(error.fault() == SolverFault::unstable_step);
      CHECK_THAT(error.what(), Catch::Contains("0.9129 ms"));
      CHECK(error.remedy() == "substeps = \"auto\" or at least 3");
    }
    scene.allow_unstable = true;
    if (kind != SolverKind::opencl) CHECK_NOTHROW(make_solver(kind, scene));  // equality_test runs one
  }
}

TEST_CASE("The block of the paper has 20,270 particles and 171,443 springs", "[stability]") {
  TissueScene block;
  const auto solver = make_solver(SolverKind::cpu_float, scene_of(block, 1e-4));
  CHECK(solver->info().particles == 20'270);
  CHECK(solver->info().springs == 171'443);
  CHECK(springs_of(block).size() == 171'443);
  CHECK(solver->info().limit->particle == 1 + 27 * (1 + 27 * 1));  // the first with all 18 springs
}

TEST_CASE(
    "Two probes that press on one particle count together: auto keeps it stable, and a step for one of them is refused",
    "[stability]") {
  TissueScene ball;
  ball.lattice = {1, 1, 1};
  ball.particle_count = 1;
  ball.fixed = FixedFaces::none();
  ball.particle_mass_kg = 1e-3;
  // Pressed from both sides, the particle swings between the probes on 500 + 500 N/m: w = 1000 /s, a limit of 2 / w = 2 ms.
  ball.tools = {{glm::dvec3(-5e-3, 0, 0), 20e-3, CouplingKind::probe, 500},
                {glm::dvec3(5e-3, 0, 0), 20e-3, CouplingKind::probe, 500}};
  ball.initial_displacement_m = {glm::dvec3(1e-6, 0, 0)};
  CHECK(step_limit(ball).step_s == Approx(2e-3));
  const auto largest_m = [](Solver& solver) {
    double most = 0;
    for (int n = 0; n < 200; ++n) {
      step(solver, 2, {});
      most = std::max(most, std::abs(solver.particle_state().displacement_m[0].x));
    }
    return most;
  };
  // One probe alone could be stepped by 2.8 ms.
  Scene coarse = scene_of(ball, 2.4e-3);
  std::get<TissueScene>(coarse.body).substeps = 1;
  CHECK_THROWS_AS(make_solver(SolverKind::cpu_double, coarse), SolverError);
  coarse.allow_unstable = true;
  CHECK(largest_m(*make_solver(SolverKind::cpu_double, coarse)) > 1e-3);  // grows a thousandfold: the limit is real
  for (const double step_s : {2.4e-3, 1e-2, 5e-2}) {
    const auto solver = make_solver(SolverKind::cpu_double, scene_of(ball, step_s));
    CHECK(largest_m(*solver) < 1e-5);  // a few times the first deflection at most, which energy kept up to 1 % allows
  }
}

TEST_CASE("A coupling's damper is shared by the particles that it holds, and so is what it takes from the limit",
          "[stability]") {
  // A tool holds free particles whose springs are so soft that only the coupling counts. n particles share its k and c, so
  // the limit of each is that of one particle with k / n and c / n.
  for (const int n : {1, 2, 4}) {
    TissueScene row;
    row.lattice = {n, 1, 1};
    row.particle_count = n;
    row.fixed = FixedFaces::none();
    row.particle_mass_kg = 1e-3;
    row.stiffness_N_per_m = 1e-9;
    row.tools = {{glm::dvec3(0), 1, CouplingKind::spring, 80, 2}};
    CHECK(step_limit(row).step_s ==
          Approx(largest_stable_step_s(Method::symplectic_euler, 80.0 / n / 1e-3, 2.0 / n / 1e-3)).epsilon(1e-6));
  }
}
