// ctest runs these tests with an environment that lacks something.
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("Without an OpenCL platform the error names the package to install, and the reference still runs",
          "[no-platform]") {
  const Scene scene = scene_of(small_block(), 1e-3);
  try {
    make_solver(SolverKind::opencl, scene);
    FAIL("an OpenCL platform was found");
  } catch (const SolverError& error) {
    CHECK(error.fault() == SolverFault::unavailable);
    CHECK_THAT(error.what(), Catch::Contains("no OpenCL platform"));
    CHECK_THAT(error.remedy(), Catch::Contains("pocl-opencl-icd"));
  }
  CHECK_NOTHROW(make_solver(SolverKind::cpu_float, scene));
}

TEST_CASE("PoCL that cannot keep compiled kernels is told as such", "[no-cache]") {
  try {
    make_solver(SolverKind::opencl, scene_of(small_block(), 1e-3));
    FAIL("PoCL built kernels without a cache");
  } catch (const SolverError& error) {
    CHECK(error.fault() == SolverFault::unavailable);
    INFO(error.what());
    CHECK_THAT(error.remedy(), Catch::Contains("POCL_CACHE_DIR"));
  }
}
