// In the place of the OpenCL solver in a build without it (EVENSTEP_OPENCL=OFF).
#include "evenstep/sim/busy_device.h"
#include "evenstep/sim/solver.h"
#include "opencl/opencl_solver.h"

namespace evenstep {
namespace {

[[noreturn]] void refuse() {
  throw SolverError(SolverFault::unavailable, "this evenstep is built without OpenCL",
                    "choose solver = \"cpu\", which computes the same bits, or build with EVENSTEP_OPENCL=ON");
}

}  // namespace

std::unique_ptr<Solver> internal::make_opencl_tissue(const Scene&, const SceneFeatures&, const SolverOptions&) { refuse(); }
std::unique_ptr<BusyDevice> make_busy_device(const SolverOptions&) { refuse(); }
bool built_with_opencl() { return false; }
void open_opencl(const SolverOptions&) { refuse(); }
OpenClDescription describe_opencl(const SolverOptions&) { refuse(); }

}  // namespace evenstep
