#include "opencl/cl_library.h"

#include <fmt/format.h>

#include "evenstep/sim/solver.h"
#include "evenstep/time/library_on_demand.h"

namespace evenstep::internal {
namespace {

ClLibrary load() {
  ClLibrary library;
#define EVENSTEP_BY_NAME(name) FunctionByName{#name, reinterpret_cast<void**>(&library.name)},
  const auto missing = load_on_demand("libOpenCL.so.1", {EVENSTEP_CL_FUNCTIONS(EVENSTEP_BY_NAME)});
#undef EVENSTEP_BY_NAME
  if (missing) {
    throw SolverError(SolverFault::unavailable, fmt::format("OpenCL cannot be loaded: {}", *missing),
                      "install ocl-icd-libopencl1 and pocl-opencl-icd, or choose solver = \"cpu\"");
  }
  return library;
}

}  // namespace

const ClLibrary& cl() {
  static const ClLibrary library = load();
  return library;
}

}  // namespace evenstep::internal
