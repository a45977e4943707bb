
#include <unistd.h>

#include "catch.h"
#include "evenstep/sim/opencl_devices.h"
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

TEST_CASE("An OpenCL device is chosen by a part of its name or its platform's, and an unknown one refused with all names",
          "[errors]") {
  const Scene scene = scene_of(small_block(), 1e-3);
  const SolverError error = refusal(scene, {"Nonesuch"});
  CHECK(error.fault() == SolverFault::unavailable);
  CHECK_THAT(error.what(), Catch::Contains("'Nonesuch'"));
  for (const OpenClListed& there : opencl_devices()) {
    CHECK_THAT(error.remedy(), Catch::Contains("'" + there.device + "' (" + there.platform + ")"));
    CHECK(make_solver(SolverKind::opencl, scene, {there.device})->info().device == there.device);
    CHECK(describe_opencl({there.platform}).platform == there.platform);
  }
}

TEST_CASE("Which of the devices is used: the one that is named, or PoCL's first, or a GPU where that is preferred",
          "[devices]") {
  const OpenClListed cpu{"Intel(R) OpenCL", "Xeon", false}, card{"NVIDIA CUDA", "NVIDIA H100 80GB HBM3", true},
      other{"AMD", "gfx942", true}, basic{"Portable Computing Language", "basic-cpu", false},
      pthread{"Portable Computing Language", "pthread-cpu", false};
  struct Row {
    std::vector<OpenClListed> there;
    const char* part;
    std::size_t usual, gpu;  // without and with a GPU preferred
  };
  const Row rows[] = {{{basic}, "", 0, 0},
                      {{card}, "", 0, 0},
                      {{card, basic, pthread}, "", 1, 0},
                      {{basic, pthread, card}, "", 0, 2},
                      {{cpu, card, other}, "", 0, 1},
                      {{cpu, basic}, "", 1, 1},
                      {{basic, pthread, card, other}, "pthread", 1, 1},
                      {{basic, pthread, card, other}, "AMD", 3, 3},
                      {{basic, pthread, card, other}, "NVIDIA", 2, 2},
                      {{card, basic, pthread}, "Portable", 1, 1}};
  for (const Row& row : rows) {
    INFO(&row - rows);
    CHECK(choose_opencl(row.there, row.part, false) == row.usual);
    CHECK(choose_opencl(row.there, row.part, true) == row.gpu);
  }
  CHECK_THROWS_AS(choose_opencl({basic, card}, "h100", true), SolverError);
}

TEST_CASE("What is said of the choice: the device, the others with the key that chooses, and a GPU that has nothing to do",
          "[devices]") {
  const std::vector<OpenClListed> there{{"Portable Computing Language", "basic-cpu", false},
                                        {"NVIDIA CUDA", "NVIDIA H100", true}};
  CHECK(opencl_text({there[0]}, 0) == "basic-cpu (Portable Computing Language)");
  CHECK(opencl_text(there, 1) ==
        "NVIDIA H100 (NVIDIA CUDA); also there: basic-cpu (Portable Computing Language); [scene] opencl_device = \"a part "
        "of a "
        "name\" chooses");
  CHECK_THAT(idle_gpu_text(there, 0), Catch::Contains("by basic-cpu") && Catch::Contains("opencl_device = \"NVIDIA H100\""));
  CHECK(idle_gpu_text(there, 1).empty());
  CHECK(idle_gpu_text({there[0]}, 0).empty());
}

TEST_CASE("A work-group size that does not divide a chunk is refused", "[errors]") {
  const Scene scene = scene_of(small_block(), 1e-3);
  for (const int size : {0, -64, 3, 257, 512}) CHECK(refusal(scene, {"", size}).remedy() == "a divisor of 256");
}

TEST_CASE("A scene larger than the memory is refused with both sizes before anything is allocated", "[errors]") {
  TissueScene huge;
  huge.lattice = {1024, 1024, 1024};  // 56 GB on a device, 97 GB in double
  huge.particle_count = 1024;
  huge.tools.clear();
  const Scene scene = scene_of(huge, 1e-4);
  const double host_bytes = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  for (const SolverKind kind : {SolverKind::cpu_double, SolverKind::opencl}) {
    const bool on_host = kind == SolverKind::cpu_double;
    if ((on_host ? host_bytes : static_cast<double>(describe_opencl().memory_bytes)) > (on_host ? 97e9 : 56e9)) {
      WARN(name_of(kind) << " has memory for the largest scene there is: nothing to refuse");
      continue;
    }
    const SolverError error = refusal(scene, {}, kind);
    CHECK(error.fault() == SolverFault::out_of_memory);
    CHECK_THAT(error.what(), Catch::Matches("the scene needs .*e\\+10 bytes of (device )?memory.*e\\+.*"));
  }
}
