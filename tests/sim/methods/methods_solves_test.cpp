// What the iterations of the implicit methods converge to, found here by elimination, and how they behave before they have
// converged.
#include "../tissue_scenes.h"
#include "catch.h"
#include "src/tissue/colours.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// 3 x 3 x 3 particles, the bottom fixed, the top's middle held, all others pushed about by up to half a spacing.
TissueScene shaken_block() {
  TissueScene block;
  block.lattice = {3, 3, 3};
  block.particle_count = 27;
  block.particle_mass_kg = 1e-4;
  block.stiffness_N_per_m = 20;
  block.damping_per_s = 30;
  block.substeps = 1;
  block.tools = {{glm::dvec3(1, 1, 2) * block.spacing_m, 1e-3}};
  std::uint32_t seed = 1;
  const auto random = [&] { return static_cast<double>((seed = seed * 1664525u + 1013904223u) >> 8) / (1 << 23) - 1; };
  for (int site = 0; site < 27; ++site) {
    const bool still = site < 9 || site == 22;
    const glm::dvec3 u(random(), random(), random()), v(random(), random(), random());
    block.initial_displacement_m.push_back(still ? glm::dvec3(0) : u * (0.5 * block.spacing_m));
    block.initial_velocity_m_per_s.push_back(still ? glm::dvec3(0) : v);
  }
  return block;
}

/// The unknowns of the free particles have the numbers 3 * index + axis.
struct System {
  explicit System(const TissueScene& of) : scene(of) {
    for (int site = 9; site < 27; ++site)
      if (site != 22) free.push_back(site);
  }
  glm::dvec3 rest_m(int site) const { return glm::dvec3(site % 3, site / 3 % 3, site / 9) * scene.spacing_m; }
  int index(int site) const {
    const auto at = std::find(free.begin(), free.end(), site);
    return at == free.end() ? -1 : static_cast<int>(at - free.begin());
  }
  std::size_t size() const { return 3 * free.size(); }
  /// Forces, and the Hessian without negative parts, row by row.
  void springs(const std::vector<glm::dvec3>& u, std::vector<double>& force_N, std::vector<double>& hessian) const {
    force_N.assign(size(), 0);
    hessian.assign(size() * size(), 0);
    for (int a = 0; a < 27; ++a) {
      for (int b = 0; b < 27; ++b) {
        const glm::dvec3 r = rest_m(b) - rest_m(a);
        const double length_m = norm(r);
        if (a == b || length_m > 1.5 * scene.spacing_m || index(a) < 0) continue;
        const glm::dvec3 d = r + u[static_cast<std::size_t>(b)] - u[static_cast<std::size_t>(a)];
        const double stretch = 1 - length_m / norm(d), across = std::max(0.0, stretch), k = scene.stiffness_N_per_m;
        const auto row = 3 * static_cast<std::size_t>(index(a));
        for (int i = 0; i < 3; ++i) {
          force_N[row + static_cast<std::size_t>(i)] += k * stretch * d[i];
          for (int j = 0; j < 3; ++j) {
            const double n = d[i] * d[j] / (norm(d) * norm(d)), value = k * (n + across * ((i == j ? 1 : 0) - n));
            hessian[(row + static_cast<std::size_t>(i)) * size() + row + static_cast<std::size_t>(j)] += value;
            if (index(b) < 0) continue;
            const auto column = 3 * static_cast<std::size_t>(index(b)) + static_cast<std::size_t>(j);
            hessian[(row + static_cast<std::size_t>(i)) * size() + column] -= value;
          }
        }
      }
    }
  }
  TissueScene scene;
  std::vector<int> free;
};

/// Gaussian elimination with row pivots.
std::vector<double> solve(std::vector<double> a, std::vector<double> b) {
  const std::size_t n = b.size();
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c + 1; r < n; ++r)
      if (std::abs(a[r * n + c]) > std::abs(a[pivot * n + c])) pivot = r;
    for (std::size_t j = 0; j < n; ++j) std::swap(a[c * n + j], a[pivot * n + j]);
    std::swap(b[c], b[pivot]);
    for (std::size_t r = c + 1; r < n; ++r) {
      const double factor = a[r * n + c] / a[c * n + c];
      for (std::size_t j = c; j < n; ++j) a[r * n + j] -= factor * a[c * n + j];
      b[r] -= factor * b[c];
    }
  }
  for (std::size_t c = n; c-- > 0;) {
    for (std::size_t j = c + 1; j < n; ++j) b[c] -= a[c * n + j] * b[j];
    b[c] /= a[c * n + c];
  }
  return b;
}

/// The velocities of the free particles after Newton steps on M (x - v0) = q (F(u0 + q x) - d M x), starting at x = 0.
std::vector<double> newton(const TissueScene& scene, const glm::dvec3& tool_m, double h_s, double q_s, int steps) {
  const System system(scene);
  const double m = scene.particle_mass_kg, d = scene.damping_per_s;
  std::vector<double> x(system.size(), 0), force_N, hessian;
  for (int n = 0; n < steps; ++n) {
    std::vector<glm::dvec3> z = scene.initial_displacement_m;
    for (std::size_t i = 0; i < system.free.size(); ++i)
      z[static_cast<std::size_t>(system.free[i])] += q_s * glm::dvec3(x[3 * i], x[3 * i + 1], x[3 * i + 2]);
    z[22] = tool_m * (q_s / h_s);
    system.springs(z, force_N, hessian);
    std::vector<double> a(hessian.size()), r(x.size());
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = q_s * q_s * hessian[i];
    for (std::size_t i = 0; i < x.size(); ++i) {
      a[i * x.size() + i] += m * (1 + q_s * d);
      const double v = scene.initial_velocity_m_per_s[static_cast<std::size_t>(system.free[i / 3])][static_cast<int>(i % 3)];
      r[i] = q_s * (force_N[i] - d * m * x[i]) - m * (x[i] - v);
    }
    const std::vector<double> dx = solve(a, r);
    for (std::size_t i = 0; i < x.size(); ++i) x[i] += dx[i];
  }
  return x;
}

constexpr double kStep_s = 2e-3;
const glm::dvec3 kTool_m(1e-3, -5e-4, 8e-4);

/// The tool's way begins at its first sample, so the second step is the one to look at. `scene` gets the state before it.
std::vector<double> velocities_after_a_step(TissueScene& scene, int iterations) {
  TissueScene run = shaken_block();
  run.method = scene.method;
  run.iterations = iterations;
  const auto solver = make_solver(SolverKind::cpu_double, scene_of(run, kStep_s));
  step(*solver, 1, {});
  ParticleState state = solver->particle_state();
  scene.initial_displacement_m = state.displacement_m;
  scene.initial_velocity_m_per_s = state.velocity_m_per_s;
  step(*solver, 1, {kTool_m});
  state = solver->particle_state();
  std::vector<double> v;
  for (const int site : System(scene).free)
    for (int axis = 0; axis < 3; ++axis) v.push_back(state.velocity_m_per_s[static_cast<std::size_t>(site)][axis]);
  return v;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
  return worst;
}

}  // namespace

TEST_CASE("Conjugate gradients of implicit Euler converge to the linearised step solved by elimination", "[methods]") {
  TissueScene block = shaken_block();
  block.method = Method::implicit_euler;
  double before = 1e9;
  for (const int iterations : {1, 3, 6, 12, 24}) {
    const std::vector<double> got = velocities_after_a_step(block, iterations);
    const double error = distance(got, newton(block, kTool_m, kStep_s, kStep_s, 1));
    INFO(iterations << " iterations: " << error);
    CHECK(error < 0.5 * before);
    before = error;
  }
  for (const int iterations : {60, 500}) {  // further iterations change nothing
    const std::vector<double> got = velocities_after_a_step(block, iterations);
    CHECK(distance(got, newton(block, kTool_m, kStep_s, kStep_s, 1)) < 1e-12);  // of 1 m/s
  }
}

TEST_CASE("Implicit midpoint is two Newton steps of the equation at half the step", "[methods]") {
  TissueScene block = shaken_block();
  block.method = Method::implicit_midpoint;
  const std::vector<double> got = velocities_after_a_step(block, 400);
  std::vector<double> exact = newton(block, kTool_m, kStep_s, kStep_s / 2, 2);
  const System system(block);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const auto site = static_cast<std::size_t>(system.free[i / 3]);
    exact[i] = 2 * exact[i] - block.initial_velocity_m_per_s[site][static_cast<int>(i % 3)];
  }
  CHECK(distance(got, exact) < 1e-12);
}

TEST_CASE("Vertex block descent converges to the nonlinear step of implicit Euler", "[methods]") {
  TissueScene block = shaken_block();
  block.method = Method::vertex_block_descent;
  double before = 1e9;
  for (const int sweeps : {1, 4, 16, 64}) {
    const std::vector<double> got = velocities_after_a_step(block, sweeps);
    const std::vector<double> exact = newton(block, kTool_m, kStep_s, kStep_s, 60);
    CHECK(distance(exact, newton(block, kTool_m, kStep_s, kStep_s, 61)) < 1e-13);  // Newton has converged
    const double error = distance(got, exact);
    INFO(sweeps << " sweeps: " << error);
    CHECK(error < 0.7 * before);
    before = error;
  }
  CHECK(before < 1e-14);  // positions are known to 1e-18 m, and the step is 2 ms
}

TEST_CASE("No two neighbours of the lattice have the same colour, and all four are used evenly", "[methods]") {
  std::array<int, internal::kColours> count{};
  for (int x = 0; x < 6; ++x)
    for (int y = 0; y < 6; ++y)
      for (int z = 0; z < 6; ++z) {
        const int colour = internal::colour_of(x, y, z);
        ++count[static_cast<std::size_t>(colour)];
        for (int dx = -1; dx <= 1; ++dx)
          for (int dy = -1; dy <= 1; ++dy)
            for (int dz = -1; dz <= 1; ++dz) {
              const int distance2 = dx * dx + dy * dy + dz * dz;
              if (distance2 == 1 || distance2 == 2) REQUIRE(internal::colour_of(x + dx, y + dy, z + dz) != colour);
            }
      }
  for (const int of_a_colour : count) CHECK(of_a_colour == 54);
}
