// The bounds of stability.h on scenes with several materials, couplings and dampers, compared with eigenvalues that power
// iteration finds on the graph itself.
#include "catch.h"
#include "evenstep/sim/stability.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// A fixed sequence of values in [0, 1), computed without libm.
struct Sequence {
  std::uint64_t state = 1;
  double next() {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state >> 40) / static_cast<double>(1u << 24);
  }
  int below(int n) { return static_cast<int>(next() * n); }
  double decades(double low, double high) {  // roughly log-uniform, by repeated factors
    double value = low;
    for (int n = below(100); n > 0 && value * 1.3 < high; --n) value *= 1.3;
    return value;
  }
};

struct Graph {
  std::vector<double> mass_kg, extra_N_per_m, extra_N_s_per_m;
  std::vector<bool> mobile;
  struct Edge {
    std::size_t a, b;
    double k;
  };
  std::vector<Edge> edges;
};

bool holds(const ToolCoupling& tool, const glm::dvec3& at_m) {
  const glm::dvec3 d = at_m - tool.center_m;
  return tool.kind != CouplingKind::probe && d.x * d.x + d.y * d.y + d.z * d.z <= tool.radius_m * tool.radius_m;
}

Graph graph_of(const TissueScene& scene) {
  Graph graph;
  const auto [nx, ny, nz] = scene.lattice;
  std::vector<double> stiffness;
  std::vector<int> held_by(scene.tools.size(), 0);
  std::vector<int> holder;
  const auto at_of = [width = nx, height = ny](std::int64_t site) {
    return glm::dvec3(site % width, site / width % height, site / width / height);
  };
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    const glm::dvec3 at = at_of(site), at_m = at * scene.spacing_m;
    double k = scene.stiffness_N_per_m, m = scene.particle_mass_kg;
    for (const MaterialRegion& region : scene.regions) {
      const bool inside = at_m.x >= region.min_m.x && at_m.x <= region.max_m.x && at_m.y >= region.min_m.y &&
                          at_m.y <= region.max_m.y && at_m.z >= region.min_m.z && at_m.z <= region.max_m.z;
      if (inside) k = region.stiffness_N_per_m, m = region.particle_mass_kg;
    }
    const bool fixed = scene.fixed.z_min && at.z == 0;
    int tool_of = -1;
    for (std::size_t tool = 0; tool < scene.tools.size(); ++tool)
      if (!fixed && holds(scene.tools[tool], at_m)) tool_of = static_cast<int>(tool), ++held_by[tool];
    holder.push_back(tool_of);
    stiffness.push_back(k);
    graph.mass_kg.push_back(m);
    graph.mobile.push_back(!fixed &&
                           (tool_of < 0 || scene.tools[static_cast<std::size_t>(tool_of)].kind != CouplingKind::grab));
    graph.extra_N_per_m.push_back(0);
    graph.extra_N_s_per_m.push_back(0);
  }
  for (std::size_t i = 0; i < holder.size(); ++i) {
    for (std::size_t j = i + 1; j < holder.size(); ++j) {
      const glm::dvec3 d = at_of(static_cast<std::int64_t>(i)) - at_of(static_cast<std::int64_t>(j));
      const double distance2 = d.x * d.x + d.y * d.y + d.z * d.z;
      if (distance2 == 1 || distance2 == 2) graph.edges.push_back({i, j, (stiffness[i] + stiffness[j]) / 2});
    }
    for (const ToolCoupling& tool : scene.tools)  // a probe can touch any particle
      if (tool.kind == CouplingKind::probe) graph.extra_N_per_m[i] += tool.stiffness_N_per_m;
    if (holder[i] < 0) continue;
    const auto held = static_cast<std::size_t>(holder[i]);
    graph.extra_N_per_m[i] += scene.tools[held].stiffness_N_per_m / held_by[held];
    graph.extra_N_s_per_m[i] += scene.tools[held].damping_N_s_per_m / held_by[held];
  }
  return graph;
}

/// The largest eigenvalue of M^-1/2 A M^-1/2 over the particles that move, found from below. A is the graph with its
/// weights.
double largest(const Graph& graph, bool dampers, double axial_N_s_per_m, int rounds) {
  const std::size_t n = graph.mass_kg.size();
  std::vector<double> x(n), y(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = graph.mobile[i] ? (i * 2654435761u % 1000) / 500.0 - 1 : 0;
  double lambda = 0;
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < n; ++i)
      y[i] = x[i] * (dampers ? graph.extra_N_s_per_m[i] : graph.extra_N_per_m[i]) / graph.mass_kg[i];
    for (const auto& [a, b, k] : graph.edges) {
      const double root_a = std::sqrt(graph.mass_kg[a]), root_b = std::sqrt(graph.mass_kg[b]);
      const double along = (dampers ? axial_N_s_per_m : k) * (x[a] / root_a - x[b] / root_b);
      y[a] += along / root_a;
      y[b] -= along / root_b;
    }
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!graph.mobile[i]) y[i] = 0;
      xx += x[i] * x[i], xy += x[i] * y[i], yy += y[i] * y[i];
    }
    if (yy == 0) return 0;
    lambda = xy / xx;
    for (std::size_t i = 0; i < n; ++i) x[i] = y[i] / std::sqrt(yy);
  }
  return lambda;
}

TissueScene random_scene(Sequence& draw) {
  TissueScene scene;
  scene.lattice = {1 + draw.below(4), 1 + draw.below(4), 1 + draw.below(4)};
  const int layer = scene.lattice[0] * scene.lattice[1];
  scene.particle_count = std::max(1, layer * scene.lattice[2] - draw.below(layer));
  scene.fixed.z_min = draw.below(2) == 0;
  const double a = scene.spacing_m;
  for (int n = draw.below(3); n > 0; --n) {
    const glm::dvec3 corner = glm::dvec3(draw.below(3), draw.below(3), draw.below(3)) * a;
    scene.regions.push_back({corner, corner + glm::dvec3(draw.below(3), draw.below(3), draw.below(3)) * a,
                             scene.stiffness_N_per_m * draw.decades(1e-4, 1e8),
                             scene.particle_mass_kg * draw.decades(1e-3, 1e3)});
  }
  if (draw.below(2) == 0) scene.axial_damping_N_s_per_m = draw.decades(1e-6, 1);
  const int top = static_cast<int>(scene.particle_count - 1) / layer;
  if (draw.below(3) > 0 && (top > 0 || !scene.fixed.z_min)) {
    const CouplingKind kinds[] = {CouplingKind::grab, CouplingKind::spring, CouplingKind::probe};
    ToolCoupling tool{glm::dvec3(0, 0, top) * a, 1.1 * a, kinds[draw.below(3)], 0, 0};
    if (tool.kind != CouplingKind::grab) tool.stiffness_N_per_m = draw.decades(1, 1e6);
    if (tool.kind == CouplingKind::spring) tool.damping_N_s_per_m = draw.decades(1e-5, 1);
    scene.tools = {tool};
  }
  return scene;
}

}  // namespace

TEST_CASE("The limit's bounds hold on 2000 random blocks of several materials, couplings and dampers, and are not idle",
          "[stability]") {
  Sequence draw;
  double tightest = 0, loosest = 1, tightest_damping = 0;
  for (int n = 0; n < 2000; ++n) {
    const TissueScene scene = random_scene(draw);
    const Graph graph = graph_of(scene);
    const StepLimit limit = step_limit(scene);
    const double lambda = largest(graph, false, 0, 80);
    const double gamma = largest(graph, true, scene.axial_damping_N_s_per_m, 80);
    CAPTURE(n, scene.lattice[0], scene.lattice[1], scene.lattice[2], scene.regions.size());
    REQUIRE(lambda <= limit.lambda_per_s2 * (1 + 1e-9));
    REQUIRE(gamma <= limit.damping_per_s * (1 + 1e-9));
    REQUIRE(limit.rest_state_lambda_per_s2 <= limit.lambda_per_s2);
    if (lambda > 0) {
      tightest = std::max(tightest, lambda / limit.lambda_per_s2);
      loosest = std::min(loosest, lambda / limit.lambda_per_s2);
    }
    if (gamma > 0) tightest_damping = std::max(tightest_damping, gamma / limit.damping_per_s);
  }
  CHECK(tightest > 0.999);
  CHECK(tightest_damping > 0.999);
  CHECK(loosest > 0.2);
}

TEST_CASE("One particle on one spring has the limit 2 / w, a chain's end half of the lattice's", "[stability]") {
  TissueScene oscillator;
  oscillator.lattice = {2, 1, 1};
  oscillator.particle_count = 2;
  oscillator.fixed = FixedFaces::none();
  oscillator.fixed.x_min = true;
  const double w2 = oscillator.stiffness_N_per_m / oscillator.particle_mass_kg;
  CHECK(step_limit(oscillator).lambda_per_s2 == Approx(w2).epsilon(1e-14));
  CHECK(step_limit(oscillator).rest_state_lambda_per_s2 == Approx(w2).epsilon(1e-14));
  CHECK(step_limit(oscillator).particle == 1);
  TissueScene chain = oscillator;
  chain.lattice = {64, 1, 1};
  chain.particle_count = 64;
  CHECK(step_limit(chain).lambda_per_s2 == Approx(4 * w2).epsilon(1e-12));
}

TEST_CASE("A stiff region sets the limit, its particle is named, and the limit falls with its square root", "[stability]") {
  for (double ratio = 1; ratio < 1e9; ratio *= 10) {
    TissueScene block = small_block();
    const double a = block.spacing_m;
    block.regions = {
        {glm::dvec3(3, 3, 3) * a, glm::dvec3(5, 5, 5) * a, block.stiffness_N_per_m * ratio, block.particle_mass_kg}};
    const StepLimit limit = step_limit(block);
    const double k_per_m = block.stiffness_N_per_m / block.particle_mass_kg;
    CHECK(limit.lambda_per_s2 <= 24 * k_per_m * ratio * (1 + 1e-12));
    CHECK(limit.lambda_per_s2 > 20 * k_per_m * ratio);  // the region contains a full cube
    CHECK(limit.rest_state_lambda_per_s2 > 8 * k_per_m * ratio);
    if (ratio > 1) CHECK(limit.particle == 4 + 8 * (4 + 7 * 4));  // the centre of the region, where all 18 springs are stiff
  }
}

TEST_CASE("The margin is the factor on stiffness that brings a step to the limit", "[stability]") {
  for (const Method method : {Method::symplectic_euler, Method::velocity_verlet, Method::rk4}) {
    for (const double damping : {0.0, 3.0, 300.0}) {
      TissueScene block = small_block();
      block.method = method;
      block.damping_per_s = damping;
      const StepLimit limit = step_limit(block);
      for (const double part : {0.01, 0.5, 1.0}) {
        const double margin = stiffness_margin(method, limit, part * limit.step_s);
        CHECK(largest_stable_step_s(method, margin * limit.lambda_per_s2, limit.damping_per_s) ==
              Approx(part * limit.step_s).epsilon(1e-12));
      }
      CHECK(stiffness_margin(method, limit, limit.step_s) == Approx(1).epsilon(1e-12));
    }
    TissueScene damped = small_block();
    damped.damping_per_s = 1e6;
    CHECK(stiffness_margin(Method::symplectic_euler, step_limit(damped), 1e-3) == 0);
  }
  TissueScene block = small_block();
  block.method = Method::implicit_euler;
  CHECK(std::isinf(step_limit(block).step_s));
  CHECK(auto_substeps(block, {450, 1}) == 1);
}
