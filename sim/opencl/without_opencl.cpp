// In the place of the OpenCL solver in a build without it (EVENSTEP_OPENCL=OFF).
#include "evenstep/sim/busy_device.h"
#include "evenstep/sim/opencl_devices.h"
#include "evenstep/sim/solver.h"
#include "evenstep/time/build_option.h"
#include "opencl/opencl_solver.h"

namespace evenstep {
namespace {

[[noreturn]] void refuse(std::string_view otherwise) {
  throw SolverError(SolverFault::unavailable, built_without(build_option::kOpenCl),
                    remedy_without(build_option::kOpenCl, otherwise));
}

}  // namespace

std::unique_ptr<Solver> internal::make_opencl_tissue(const Scene&, const SceneFeatures&, const SolverOptions&) {
  refuse(kInsteadOfOpenCl);
}
std::unique_ptr<BusyDevice> make_busy_device(const SolverOptions&) { refuse(kInsteadOfBurning); }
bool built_with_opencl() { return false; }
void open_opencl(const SolverOptions&) { refuse(kInsteadOfOpenCl); }
const std::vector<OpenClListed>& opencl_devices() { refuse(kInsteadOfOpenCl); }
OpenClDescription describe_opencl(const SolverOptions&) { refuse(kInsteadOfOpenCl); }

}  // namespace evenstep
