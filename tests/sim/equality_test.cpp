// cpu float and OpenCL agree bit for bit. The tests run again on every PoCL driver and number of threads (CMakeLists.txt).
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

void require_equal(Solver& reference, Solver& other, int tools, int steps, bool until_non_finite = false) {
  for (int n = 0; n < steps; ++n) {
    const ToolResponse expected = step(reference, tools, wandering_tools(n % 200)),
                       got = step(other, tools, wandering_tools(n % 200));
    INFO("step " << n);
    REQUIRE(same_bits(expected, got));
    for (const glm::dvec3& force_N : got.force_N) {
      if (std::isnan(force_N.x)) REQUIRE(same_bits(force_N.x, std::numeric_limits<double>::quiet_NaN()));
    }
    REQUIRE(reference.state_digest() == other.state_digest());
    REQUIRE(same_bits(reference.verdict().energy_J, other.verdict().energy_J));
    REQUIRE(same_bits(reference.verdict().energy_growth, other.verdict().energy_growth));
    REQUIRE(reference.verdict().first_bad_step == other.verdict().first_bad_step);
  }
  REQUIRE(reference.verdict().non_finite == until_non_finite);
}

}  // namespace

TEST_CASE(
    "Forces, digest and energy of 200 steps are equal on cpu float and OpenCL for every work-group size, with and without "
    "damping",
    "[equality][sweep]") {
  for (const int work_group_size : {8, 64, 256}) {
    for (const double damping_per_s : {0.0, 20.0}) {
      if (damping_per_s > 0 && work_group_size != 64) continue;
      TissueScene block = small_block();
      block.damping_per_s = damping_per_s;
      const Scene scene = scene_of(block, 1.0 / 450, true);
      const auto cpu = make_solver(SolverKind::cpu_float, scene);
      const auto opencl = make_solver(SolverKind::opencl, scene, {"", work_group_size});
      INFO("work-group size " << work_group_size << ", damping " << damping_per_s << ", " << opencl->info().device);
      require_equal(*cpu, *opencl, 2, 200);
      CHECK(norm(step(*cpu, 2, wandering_tools(199)).force_N[0]) > 0.1);
    }
  }
}

TEST_CASE("A diverging run is equal too, through overflow to NaN", "[equality]") {
  TissueScene block = small_block();
  block.substeps = 1;
  Scene scene = scene_of(block, 2.5e-3, true);
  scene.allow_unstable = true;
  require_equal(*make_solver(SolverKind::cpu_float, scene), *make_solver(SolverKind::opencl, scene), 2, 400, true);
}

TEST_CASE("Free blocks and blocks without tools are equal", "[equality]") {
  TissueScene block = small_block();
  block.fixed = FixedFaces::none();
  const Scene free = scene_of(block, 1.0 / 450, true);  // the same kernels as above
  require_equal(*make_solver(SolverKind::cpu_float, free), *make_solver(SolverKind::opencl, free), 2, 100);
  block.tools.clear();
  const Scene alone = scene_of(block, 1.0 / 450, true);
  require_equal(*make_solver(SolverKind::cpu_float, alone), *make_solver(SolverKind::opencl, alone), 0, 20);
}

TEST_CASE("20 steps of the paper's 20,270 particles are equal", "[equality]") {
  TissueScene block;
  const double a = block.spacing_m;
  block.tools = {{glm::dvec3(8, 13, 25) * a, 1.5 * a}, {glm::dvec3(18, 13, 25) * a, 1.5 * a}};
  const Scene scene = scene_of(block, 1.0 / 450);
  require_equal(*make_solver(SolverKind::cpu_float, scene), *make_solver(SolverKind::opencl, scene), 2, 20);
}
