// What each feature of a tissue costs: the process CPU of a step with the feature divided by that of a step without, for
// 20,270 particles and one substep, with forces read after every step. Prints a table for `cpu` float and for OpenCL on PoCL
// basic:
//   POCL_DEVICES=basic build/bench/bench_feature_costs [ROUNDS]
// In every round each scene makes a few steps; the ratio is the median over the rounds.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/clock/wall_clock.h"
#include "evenstep/sim/solver.h"

namespace {

using namespace evenstep;

constexpr Rate kStepRate{4000, 1};
constexpr int kWarmUp_steps = 300;  // the wave has crossed the block
constexpr int kStepsPerRound = 20;

/// The scene to which features are added: a block with a fixed bottom, held by one grab.
Scene plain() {
  TissueScene tissue;
  tissue.substeps = 1;
  tissue.tools = {{glm::dvec3(13, 13, 26) * tissue.spacing_m, 1.5 * tissue.spacing_m}};
  Scene scene{tissue, kStepRate, 1};
  scene.needs_state_digest = false;
  return scene;
}

struct Feature {
  const char* name;  ///< as in left_out
  std::function<void(Scene&, TissueScene&)> add;
  std::function<void(Scene&, TissueScene&)> base;  ///< the scene that it is compared with, if not plain()
};

const std::vector<Feature>& features() {
  const auto free_of_tools = [](Scene& scene, TissueScene& tissue) {
    tissue.tools.clear();
    scene.tool_count = 0;
  };
  const auto second = [](CouplingKind kind, double stiffness_N_per_m) {
    return [=](Scene& scene, TissueScene& tissue) {
      tissue.tools.push_back({glm::dvec3(6, 6, 26) * tissue.spacing_m, 1.5 * tissue.spacing_m, kind, stiffness_N_per_m, 0});
      scene.tool_count = 2;
    };
  };
  static const std::vector<Feature> all{
      {"regions",
       [](Scene&, TissueScene& t) {
         t.regions = {{glm::dvec3(0.04), glm::dvec3(0.09), 2 * t.stiffness_N_per_m, t.particle_mass_kg}};
       },
       {}},
      {"damping", [](Scene&, TissueScene& t) { t.damping_per_s = 20; }, {}},
      {"axial damping", [](Scene&, TissueScene& t) { t.axial_damping_N_s_per_m = 1e-3; }, {}},
      {"gravity", [](Scene&, TissueScene& t) { t.gravity_m_per_s2.z = -0.1; }, {}},
      {"fixed particles", [](Scene&, TissueScene&) {}, [](Scene&, TissueScene& t) { t.fixed = FixedFaces::none(); }},
      {"tools", [](Scene&, TissueScene&) {}, free_of_tools},
      {"second tool", second(CouplingKind::grab, 0), {}},
      {"grab", second(CouplingKind::grab, 0), {}},
      {"spring coupling", second(CouplingKind::spring, 200), {}},
      {"probe", second(CouplingKind::probe, 100), {}},
      {"local model", [](Scene& s, TissueScene&) { s.local_model = LocalModel::instantaneous; }, {}},
      {"variable step", [](Scene& s, TissueScene&) { s.variable_step = true; }, {}},
      {"energy", [](Scene& s, TissueScene&) { s.needs_energy = true; }, {}},
      {"state digest", [](Scene& s, TissueScene&) { s.needs_state_digest = true; }, {}},
  };
  return all;
}

/// 1 mm out and back again, at 4 kHz 10 mm/s.
double way_m(std::int64_t n) {
  const std::int64_t phase = n % 800;
  return static_cast<double>(phase < 400 ? phase : 800 - phase) * 2.5e-6;
}

class Run {
 public:
  Run(SolverKind kind, const Scene& scene) : scene_(scene), solver_(make_solver(kind, scene)) {
    for (int n = 0; n < kWarmUp_steps; ++n) step();
  }
  void time_round() {
    const double began_s = process_cpu_seconds();
    for (int n = 0; n < kStepsPerRound; ++n) step();
    cpu_s.push_back(process_cpu_seconds() - began_s);
  }
  std::vector<double> cpu_s;

 private:
  void step() {
    const std::array at{glm::dvec3(way_m(n_), 0, 0), glm::dvec3(0, way_m(n_), 0)};
    ++n_;
    const std::span tools(at.data(), static_cast<std::size_t>(scene_.tool_count));
    solver_->step(tools, scene_.variable_step ? std::optional(period_s(kStepRate)) : std::nullopt);
    if (scene_.needs_state_digest) solver_->state_digest();
  }
  Scene scene_;
  std::unique_ptr<Solver> solver_;
  std::int64_t n_ = 0;
};

Scene changed(Scene scene, const std::function<void(Scene&, TissueScene&)>& change) {
  if (change) change(scene, std::get<TissueScene>(scene.body));
  return scene;
}

/// The cost in percent above the base.
double cost(SolverKind kind, const Feature& feature, int rounds) {
  Run base(kind, changed(plain(), feature.base)), with(kind, changed(plain(), feature.add));
  std::vector<double> ratios;
  for (int round = 0; round < rounds; ++round) {
    base.time_round();
    with.time_round();
    ratios.push_back(with.cpu_s.back() / base.cpu_s.back());
  }
  std::nth_element(ratios.begin(), ratios.begin() + rounds / 2, ratios.end());
  return 100 * (ratios[static_cast<std::size_t>(rounds / 2)] - 1);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 45;
  std::printf("%-20s%12s%12s\n", "feature", "cpu %", "opencl %");
  for (const Feature& feature : features()) {
    std::printf("%-20s%12.0f%12.0f\n", feature.name, cost(SolverKind::cpu_float, feature, rounds),
                cost(SolverKind::opencl, feature, rounds));
    std::fflush(stdout);
  }
}
