// These tests run under Oclgrind (oclgrind_test.sh), an OpenCL other than PoCL that interprets each work-item and watches
// every access.
#include "catch.h"
#include "feature_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("On Oclgrind forces, digest and energy are those of cpu float, bit for bit") {
  TissueScene block = small_block();
  block.lattice = {3, 3, 4};  // fewer cells than one chunk of sums, so the kernels run over their padding too
  block.particle_count = 3 * 3 * 4 - 2;
  block.damping_per_s = 20;
  block.substeps = 3;
  block.tools = {{glm::dvec3(0, 0, 2) * block.spacing_m, 4e-3}, {glm::dvec3(2, 2, 2) * block.spacing_m, 6e-3}};
  const Scene scene = scene_of(block, 1.0 / 450, true);
  const auto cpu = make_solver(SolverKind::cpu_float, scene);
  const auto opencl = make_solver(SolverKind::opencl, scene, {"", 64});
  REQUIRE(opencl->info().device.find("Oclgrind") != std::string::npos);
  for (int n = 0; n < 10; ++n) {
    INFO("step " << n);
    const ToolResponse expected = step(*cpu, 2, wandering_tools(20 * n)), got = step(*opencl, 2, wandering_tools(20 * n));
    REQUIRE(same_bits(expected, got));
    REQUIRE(cpu->state_digest() == opencl->state_digest());
    REQUIRE(same_bits(cpu->verdict().energy_J, opencl->verdict().energy_J));
  }
  CHECK(norm(step(*cpu, 2, wandering_tools(199)).force_N[0]) > 0.1);
}

TEST_CASE("On Oclgrind implicit Euler is that of cpu float, bit for bit") {
  for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::spring}) {  // and beside it a spring, a probe
    TissueScene block = featured_block({true, true, true, true, tool, Method::implicit_euler});
    block.iterations = 4;
    const Scene scene = scene_of(block, 1e-3, true);
    const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
    for (int n = 0; n < 2; ++n) {
      const ToolResponse expected = step(*cpu, 2, wandering_tools(20 * n));
      REQUIRE(same_bits(expected, step(*opencl, 2, wandering_tools(20 * n))));
      REQUIRE(cpu->state_digest() == opencl->state_digest());
      REQUIRE(same_bits(cpu->verdict().energy_J, opencl->verdict().energy_J));
    }
    CHECK(norm(step(*cpu, 2, wandering_tools(60)).force_N[0]) > 0.01);
  }
}

TEST_CASE("On Oclgrind a scene with every feature is that of cpu float, bit for bit") {
  for (const Method method : {Method::symplectic_euler, Method::velocity_verlet}) {
    for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::spring}) {  // and beside it a spring, a probe
      Scene scene = scene_of(featured_block({true, true, true, true, tool, method}), 1e-3, true);
      scene.variable_step = true;
      scene.local_model = LocalModel::instantaneous;
      const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
      for (int n = 0; n < 2; ++n) {
        const Positions at = wandering_tools(20 * n);
        REQUIRE(same_bits(step(*cpu, 2, at), step(*opencl, 2, at)));
        REQUIRE(cpu->state_digest() == opencl->state_digest());
        REQUIRE(same_bits(cpu->verdict().energy_J, opencl->verdict().energy_J));
      }
    }
  }
}
