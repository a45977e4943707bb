// Drag is a force with the same coefficient in N s/m on every particle, whatever its mass.
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

/// A block with drag in which every particle weighs `ratio` times 0.1 g. The mass is given for the scene or for a region
/// that contains the whole scene. Both mean the same.
TissueScene block(double ratio, bool region, Method method) {
  TissueScene tissue = small_block();
  const double drag_N_s_per_m = 5e-3;
  tissue.particle_mass_kg = region ? 1e-4 : ratio * 1e-4;
  tissue.damping_per_s = drag_N_s_per_m / tissue.particle_mass_kg;
  tissue.axial_damping_N_s_per_m = 1e-4;
  tissue.method = method;
  tissue.substeps = 4;
  tissue.iterations = iterates(method) ? 20 : 0;
  tissue.tools[1].kind = CouplingKind::spring;
  tissue.tools[1].stiffness_N_per_m = 40;
  tissue.tools[1].damping_N_s_per_m = 0.01;
  if (region) tissue.regions = {{glm::dvec3(-1), glm::dvec3(1), tissue.stiffness_N_per_m, ratio * 1e-4}};
  return tissue;
}

/// The forces of both tools over 20 steps of 1 ms.
std::vector<glm::dvec3> forces_of(SolverKind kind, const TissueScene& tissue, bool variable_step) {
  Scene scene = scene_of(tissue, 1e-3);
  scene.variable_step = variable_step;
  const auto solver = make_solver(kind, scene);
  std::vector<glm::dvec3> forces_N;
  for (int n = 0; n <= 20; ++n) {
    const auto positions = wandering_tools(n);
    const ToolResponse response = variable_step ? solver->step(positions, 0.8e-3) : solver->step(positions);
    forces_N.push_back(response.force_N[0]);
    forces_N.push_back(response.force_N[1]);
  }
  return forces_N;
}

}  // namespace

TEST_CASE("A region of another mass has the drag of a scene of that mass, with every method", "[physics][sweep]") {
  // feature_equality_test holds OpenCL to the bits of cpu float.
  for (const SolverKind kind : {SolverKind::cpu_float, SolverKind::cpu_double}) {
    for (const Method method : kAllMethods) {
      for (const double ratio : {0.5, 4.0}) {
        for (const bool variable_step : {false, true}) {
          INFO(name_of(kind) << " " << name_of(method) << " " << ratio << (variable_step ? ", variable" : ""));
          const std::vector<glm::dvec3> forces_N = forces_of(kind, block(ratio, true, method), variable_step);
          const std::vector<glm::dvec3> expected_N = forces_of(kind, block(ratio, false, method), variable_step);
          double worst_N = 0, largest_N = 0;
          for (std::size_t n = 0; n < forces_N.size(); ++n) {
            worst_N = std::max(worst_N, norm(forces_N[n] - expected_N[n]));
            largest_N = std::max(largest_N, norm(expected_N[n]));
          }
          // The equations are the same but rounded in other places. Drag for half the mass would make a difference of
          // percents.
          CHECK(worst_N < (kind == SolverKind::cpu_double ? 1e-9 : 2e-3) * largest_N);
        }
      }
    }
  }
}

TEST_CASE("The step limit takes the drag of the lightest particle that moves", "[stability]") {
  for (const double ratio : {0.25, 4.0}) {
    const StepLimit in_region = step_limit(block(ratio, true, Method::symplectic_euler));
    const StepLimit in_scene = step_limit(block(ratio, false, Method::symplectic_euler));
    CHECK(in_region.damping_per_s == Approx(in_scene.damping_per_s).epsilon(1e-12));
    CHECK(in_region.step_s == Approx(in_scene.step_s).epsilon(1e-12));
  }
}

TEST_CASE("The limit at rest knows a coupling: a particle on a coupling alone swings with its stiffness", "[stability]") {
  TissueScene tissue;
  tissue.lattice = {1, 1, 1};
  tissue.particle_count = 1;
  tissue.fixed = FixedFaces::none();
  tissue.particle_mass_kg = 1e-4;
  tissue.stiffness_N_per_m = 10;
  tissue.tools = {{glm::dvec3(0), 1e-3, CouplingKind::spring, 500, 0}};
  CHECK(step_limit(tissue).rest_state_lambda_per_s2 == Approx(500 / 1e-4).epsilon(1e-6));
  // In a block, a coupling a hundred times as stiff as the springs sets the step limit, also at rest.
  TissueScene block = small_block();
  const double without = step_limit(block).rest_state_lambda_per_s2;
  block.tools = {{glm::dvec3(1, 3, 7) * 5e-3, 1e-3, CouplingKind::spring, 2000, 0}};
  const StepLimit limit = step_limit(block);
  CHECK(limit.rest_state_lambda_per_s2 > 2000 / 1e-4);
  CHECK(limit.rest_state_lambda_per_s2 > 5 * without);
  CHECK(limit.rest_state_lambda_per_s2 <= limit.lambda_per_s2);
}

TEST_CASE("What sets the limit is a particle with its site, or else it is said what is there instead", "[stability]") {
  const TissueScene block = small_block();
  const StepLimit limit = step_limit(block);
  REQUIRE(limit.particle >= 0);
  CHECK(what_sets(block, limit).find("particle " + std::to_string(limit.particle) + " at site (") == 0);
  TissueScene alone;
  alone.lattice = {1, 1, 1};
  alone.particle_count = 1;
  alone.fixed = FixedFaces::none();
  CHECK(what_sets(alone, step_limit(alone)) ==
        "no particle that moves has a spring; they are those of one particle on one spring");
  alone.tools = {{glm::dvec3(0, 0, 1), 1e-3, CouplingKind::probe, 100, 0}};
  CHECK(what_sets(alone, step_limit(alone)) == "no particle that moves has a spring; what the probes may touch sets them");
}
