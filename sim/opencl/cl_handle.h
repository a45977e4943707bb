#pragma once
/// Owning OpenCL handles, and errors that contain the names of the call and of the error code.

#include <string>
#include <string_view>
#include <utility>

#include "evenstep/sim/solver.h"
#include "opencl/cl_library.h"

namespace evenstep::internal {

/// Throws SolverError with the call, the error code and, if there is one, the remedy.
void check_cl(cl_int code, std::string_view call);

template <class Handle, auto Release>
class ClHandle {
 public:
  ClHandle() = default;
  explicit ClHandle(Handle handle) : handle_(handle) {}
  ClHandle(ClHandle&& other) noexcept : handle_(std::exchange(other.handle_, nullptr)) {}
  ClHandle& operator=(ClHandle&& other) noexcept {
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~ClHandle() {
    if (handle_) (cl().*Release)(handle_);
  }
  Handle get() const { return handle_; }

 private:
  Handle handle_ = nullptr;
};
using ClContext = ClHandle<cl_context, &ClLibrary::clReleaseContext>;
using ClQueue = ClHandle<cl_command_queue, &ClLibrary::clReleaseCommandQueue>;
using ClProgram = ClHandle<cl_program, &ClLibrary::clReleaseProgram>;
using ClKernel = ClHandle<cl_kernel, &ClLibrary::clReleaseKernel>;
using ClBuffer = ClHandle<cl_mem, &ClLibrary::clReleaseMemObject>;

/// The device a scene runs on.
struct ClDevice {
  cl_platform_id platform = nullptr;
  cl_device_id device = nullptr;
  std::string name;
};
/// The one that choose_opencl chooses of all. Throws SolverError.
ClDevice choose_device(const SolverOptions& options);
OpenClDescription describe(const ClDevice& device);

}  // namespace evenstep::internal
