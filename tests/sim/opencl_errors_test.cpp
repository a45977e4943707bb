
#include "catch.h"
#include "tissue_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

SolverError refusal(const Scene& scene, const SolverOptions& options, SolverKind kind = SolverKind::opencl) {
  try {
    make_solver(kind, scene, options);
  } catch (const SolverError& error) {
    return error;
  }
  FAIL("not refused");
  return {SolverFault::unavailable, "", ""};
}

}  // namespace

TEST_CASE("An unknown platform or device is refused with the names that are there", "[errors]") {
  const Scene scene = scene_of(small_block(), 1e-3);
  const SolverError platform = refusal(scene, {"Nonesuch"});
  CHECK_THAT(platform.what(), Catch::Contains("'Nonesuch'"));
  CHECK_THAT(platform.remedy(), Catch::Contains("'Portable Computing Language'"));
  const SolverError device = refusal(scene, {"Portable", "nonesuch"});
  CHECK_THAT(device.what(), Catch::Contains("'nonesuch'"));
  const std::string there = make_solver(SolverKind::opencl, scene)->info().device;
  CHECK_THAT(device.remedy(), Catch::Contains("'" + there + "'"));
  CHECK(make_solver(SolverKind::opencl, scene, {"Portable", there})->info().device == there);
}

TEST_CASE("A work-group size that does not divide a chunk is refused", "[errors]") {
  const Scene scene = scene_of(small_block(), 1e-3);
  for (const int size : {0, -64, 3, 257, 512}) CHECK(refusal(scene, {"", "", size}).remedy() == "a divisor of 256");
}

TEST_CASE("A scene larger than the memory is refused with both sizes before anything is allocated", "[errors]") {
  TissueScene huge;
  huge.lattice = {1024, 1024, 1024};  // 56 GB on a device, 97 GB in double
  huge.particle_count = 1024;
  huge.tools.clear();
  const Scene scene = scene_of(huge, 1e-4);
  for (const SolverKind kind : {SolverKind::cpu_double, SolverKind::opencl}) {
    const SolverError error = refusal(scene, {}, kind);
    CHECK(error.fault() == SolverFault::out_of_memory);
    CHECK_THAT(error.what(), Catch::Matches("the scene needs .*e\\+10 bytes of (device )?memory.*e\\+.*"));
  }
}
