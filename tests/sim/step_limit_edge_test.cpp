// Linear scenes begin to diverge exactly at the step limit, whatever they contain.
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Edge {
  const char* name;
  TissueScene scene;
};

TissueScene column(int n, bool fixed) {
  TissueScene tissue;
  tissue.lattice = {1, 1, n};
  tissue.particle_count = n;
  tissue.spacing_m = 0.01;
  tissue.particle_mass_kg = 1e-3;
  tissue.stiffness_N_per_m = 40;
  tissue.fixed = FixedFaces::none();
  tissue.fixed.z_min = fixed;
  tissue.substeps = 1;
  tissue.initial_displacement_m.assign(static_cast<std::size_t>(n), glm::dvec3(0));
  tissue.initial_displacement_m.back().z = 1e-10;  // grows 300-fold in 20 steps and must stay in the linear range
  return tissue;
}

std::vector<Edge> edges() {
  std::vector<Edge> all{{"two masses", column(2, false)}};
  const auto with = [&](const char* name, int n, bool fixed, auto change) {
    TissueScene scene = column(n, fixed);
    change(scene);
    all.push_back({name, scene});
  };
  with("axial damper", 2, false, [](TissueScene& t) { t.axial_damping_N_s_per_m = 0.05; });
  with("damping", 2, true, [](TissueScene& t) { t.damping_per_s = 150; });
  with("stiffer and lighter region", 2, false, [](TissueScene& t) { t.regions = {{{-1, -1, -1}, {1, 1, 1}, 90, 4e-4}}; });
  with("coupling", 2, true, [](TissueScene& t) { t.tools = {{{0, 0, 0.01}, 1e-3, CouplingKind::spring, 100}}; });
  with("coupling with a damper", 2, true, [](TissueScene& t) {
    t.tools = {{{0, 0, 0.01}, 1e-3, CouplingKind::spring, 100, 0.2}};
  });
  with("probe", 2, true, [](TissueScene& t) {  // 1 mm deep; the particle gives way and comes to rest at 0.36 mm
    t.tools = {{{0, 0, 0.014}, 5e-3, CouplingKind::probe, 70}};
    t.initial_displacement_m.back().z -= 1e-3 * 70 / (70 + t.stiffness_N_per_m);
  });
  return all;
}

/// The farthest distance from rest, divided by the farthest one in the first 20 steps.
double growth(const TissueScene& tissue, double part_of_limit) {
  Scene scene = scene_of(tissue, 1e-3);
  scene.step_rate = {1'000'000'000'000, std::llround(part_of_limit * step_limit(tissue).step_s * 1e12)};
  scene.allow_unstable = true;
  const auto solver = make_solver(SolverKind::cpu_double, scene);
  double first = 0, last = 0;
  for (int n = 0; n < 400; ++n) {
    step(*solver, static_cast<int>(tissue.tools.size()), {});
    const double v = std::abs(solver->particle_state().velocity_m_per_s.back().z);
    if (n < 20) first = std::max(first, v);
    if (n >= 380) last = std::max(last, v);
    if (v > 1e3 * first && n > 20) return v / first;
  }
  return last / first;
}

}  // namespace

TEST_CASE("A linear scene is stable 1 percent below its limit and diverges 1 percent above it", "[stability][features]") {
  for (const Method method : {Method::symplectic_euler, Method::velocity_verlet}) {
    for (auto& [name, scene] : edges()) {
      INFO(name);
      scene.method = method;
      CHECK(growth(scene, 0.99) < 10);
      CHECK(growth(scene, 1.01) > 100);
    }
  }
}
