// Whatever a scene has, cpu float and OpenCL agree bit for bit, and so does a solver with everything compiled in.
#include "catch.h"
#include "cpu/cpu_solvers.h"
#include "feature_scenes.h"
#include "opencl/opencl_solver.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr int kSteps = 50;

void require_equal(Solver& a, Solver& b, int steps = kSteps) {
  double largest_N = 0;
  for (int n = 0; n < steps; ++n) {
    INFO("step " << n);
    const ToolResponse expected = step(a, 2, wandering_tools(3 * n)), got = step(b, 2, wandering_tools(3 * n));
    REQUIRE(same_bits(expected, got));
    REQUIRE(a.state_digest() == b.state_digest());
    REQUIRE(same_bits(a.verdict().energy_J, b.verdict().energy_J));
    REQUIRE(same_bits(a.verdict().energy_growth, b.verdict().energy_growth));
    for (const glm::dvec3& force_N : expected.force_N) largest_N = std::max(largest_N, norm(force_N));
  }
  REQUIRE_FALSE(a.verdict().non_finite);
  REQUIRE(largest_N > 0.01);
}

Scene featured(const Has& has) { return scene_of(featured_block(has), 1e-3, true); }

Has everything(Method method, CouplingKind tool) { return {true, true, true, true, tool, method}; }

/// Compares the particles themselves, because digest and energy take as long to compile as all the rest.
void require_equal_combinations(Method method, CouplingKind tool) {
  for (const Has& has : every_combination({method})) {
    if (has.tool != tool || !is_tried(has)) continue;
    INFO(text_of(has));
    Scene scene = scene_of(featured_block(has), 1e-3);
    scene.needs_state_digest = false;
    const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
    for (int n = 0; n < kSteps; ++n)
      REQUIRE(same_bits(step(*cpu, 2, wandering_tools(3 * n)), step(*opencl, 2, wandering_tools(3 * n))));
    const ParticleState a = cpu->particle_state(), b = opencl->particle_state();
    const std::size_t bytes = a.displacement_m.size() * sizeof(glm::dvec3);
    REQUIRE(std::memcmp(a.displacement_m.data(), b.displacement_m.data(), bytes) == 0);
    REQUIRE(std::memcmp(a.velocity_m_per_s.data(), b.velocity_m_per_s.data(), bytes) == 0);
    REQUIRE(norm(a.displacement_m.back()) > 1e-6);
  }
}

/// Compares also while the steps change their length, and with steps beyond the limit.
void require_equal_with_everything(Method method, CouplingKind tool, int work_group_size) {
  INFO(text_of(everything(method, tool)) << ", work-group size " << work_group_size);
  Scene scene = featured(everything(method, tool));
  scene.variable_step = true;
  const auto cpu = make_solver(SolverKind::cpu_float, scene);
  const auto opencl = make_solver(SolverKind::opencl, scene, {"", work_group_size});
  require_equal(*cpu, *opencl, 20);
  for (int n = 0; n < 100; ++n) {  // far over the limit, to NaN
    const auto positions_m = wandering_tools(n);
    const double step_s = n < 20 ? 1e-3 * (1 + n % 3) : 0.02;
    REQUIRE(same_bits(cpu->step(std::span(positions_m), step_s), opencl->step(std::span(positions_m), step_s)));
    REQUIRE(cpu->state_digest() == opencl->state_digest());
    REQUIRE(same_bits(cpu->verdict().energy_J, opencl->verdict().energy_J));
  }
  REQUIRE(cpu->verdict().non_finite == (method != Method::implicit_euler));  // for that one no step is too long
}

}  // namespace

TEST_CASE("Grabs: symplectic Euler with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  require_equal_combinations(Method::symplectic_euler, CouplingKind::grab);
}
TEST_CASE("Couplings: symplectic Euler with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  require_equal_combinations(Method::symplectic_euler, CouplingKind::spring);
}
TEST_CASE("Probes: symplectic Euler with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  require_equal_combinations(Method::symplectic_euler, CouplingKind::probe);
}
TEST_CASE("Every tool: implicit Euler with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::spring, CouplingKind::probe})
    require_equal_combinations(Method::implicit_euler, tool);
}
TEST_CASE("Grabs: velocity Verlet with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  require_equal_combinations(Method::velocity_verlet, CouplingKind::grab);
}
TEST_CASE("Couplings: velocity Verlet with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  require_equal_combinations(Method::velocity_verlet, CouplingKind::spring);
}
TEST_CASE("Probes: velocity Verlet with any features has the same bits on cpu float and OpenCL", "[features][sweep]") {
  require_equal_combinations(Method::velocity_verlet, CouplingKind::probe);
}

TEST_CASE("The particles' state is equal on cpu float and OpenCL after every step, odd or even", "[features]") {
  TissueScene block = featured_block({false, false, true, false, CouplingKind::spring});
  block.substeps = 1;
  const Scene scene = scene_of(block, 2e-4);
  const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
  for (int n = 0; n < 7; ++n) {
    REQUIRE(same_bits(step(*cpu, 2, wandering_tools(3 * n)), step(*opencl, 2, wandering_tools(3 * n))));
    const ParticleState a = cpu->particle_state(), b = opencl->particle_state();
    INFO("step " << n);
    REQUIRE(a.displacement_m == b.displacement_m);
    REQUIRE(a.velocity_m_per_s == b.velocity_m_per_s);
  }
}

TEST_CASE("A coupling beside a grab is equal on cpu float and OpenCL, whichever tool comes first", "[features]") {
  TissueScene block = featured_block({false, false, false, false, CouplingKind::grab});  // a grab, then a spring
  for (int order = 0; order < 4; ++order) {
    block.method = order < 2 ? Method::symplectic_euler : Method::velocity_verlet;  // two ways to move what is grabbed
    const Scene scene = scene_of(block, 1e-3);
    const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
    for (int n = 0; n < 20; ++n) {
      const ToolResponse expected = step(*cpu, 2, wandering_tools(3 * n));
      REQUIRE(same_bits(expected, step(*opencl, 2, wandering_tools(3 * n))));
      if (n > 5) REQUIRE((norm(expected.force_N[0]) > 0 && norm(expected.force_N[1]) > 0));
    }
    std::swap(block.tools[0], block.tools[1]);
  }
}

TEST_CASE("With every feature no work-group size, no changing step and no divergence makes OpenCL differ from cpu float",
          "[features][equality][sweep]") {  // runs on every driver of PoCL
  require_equal_with_everything(Method::symplectic_euler, CouplingKind::spring, 1);
  for (const Method method : {Method::symplectic_euler, Method::velocity_verlet, Method::implicit_euler})
    require_equal_with_everything(method, CouplingKind::spring, 64);  // that scene has a probe, too
}

TEST_CASE("With every feature and any tool no changing step and no divergence makes OpenCL differ from cpu float",
          "[features][sweep]") {
  require_equal_with_everything(Method::symplectic_euler, CouplingKind::spring, 256);
  for (const Method method : {Method::symplectic_euler, Method::velocity_verlet, Method::implicit_euler})
    for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::probe})
      require_equal_with_everything(method, tool, 64);
}

TEST_CASE("A solver with every feature compiled in gives the bits of the one made for the scene", "[features][sweep]") {
  for (const Has& has : every_combination()) {
    INFO(text_of(has));
    const Scene scene = featured(has);
    const auto made = make_solver(SolverKind::cpu_float, scene);
    require_equal(*made, *internal::make_cpu_tissue_float(scene, internal::every_feature(scene)));
    made->reset();
    const bool none = !has.damping && !has.gravity && !has.regions && !has.axial_damping;
    if (none)  // where most is compiled in: two builds of a second each
      require_equal(*made, *internal::make_opencl_tissue(scene, internal::every_feature(scene), {}));
    require_equal(*make_solver(SolverKind::cpu_double, scene),
                  *internal::make_cpu_tissue_double(scene, internal::every_feature(scene)));
  }
}
