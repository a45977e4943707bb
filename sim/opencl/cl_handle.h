#pragma once
/// Owning OpenCL handles, and errors that contain the names of the call and of the error code.

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <string>
#include <string_view>
#include <utility>

namespace evenstep::internal {

/// Throws SolverError with the call, the error code and, if there is one, the remedy.
void check_cl(cl_int code, std::string_view call);

template <class Handle, cl_int (*Release)(Handle)>
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
    if (handle_) Release(handle_);
  }
  Handle get() const { return handle_; }

 private:
  Handle handle_ = nullptr;
};
using ClContext = ClHandle<cl_context, clReleaseContext>;
using ClQueue = ClHandle<cl_command_queue, clReleaseCommandQueue>;
using ClProgram = ClHandle<cl_program, clReleaseProgram>;
using ClKernel = ClHandle<cl_kernel, clReleaseKernel>;
using ClBuffer = ClHandle<cl_mem, clReleaseMemObject>;

/// The device a scene runs on.
struct ClDevice {
  cl_platform_id platform = nullptr;
  cl_device_id device = nullptr;
  std::string name;
};
/// Chooses a device by parts of the names. With an empty platform it is PoCL if that is there, otherwise the first one.
/// Errors list the devices that there are.
ClDevice choose_device(const std::string& platform_part, const std::string& device_part);

}  // namespace evenstep::internal
