#include "opencl/cl_handle.h"

#include <fmt/format.h>

#include <vector>

#include "evenstep/sim/opencl_devices.h"

namespace evenstep::internal {
namespace {

struct CodeName {
  cl_int code;
  const char* name;
};
constexpr CodeName kNames[] = {{-1, "CL_DEVICE_NOT_FOUND"},       {-2, "CL_DEVICE_NOT_AVAILABLE"},
                               {-3, "CL_COMPILER_NOT_AVAILABLE"}, {-4, "CL_MEM_OBJECT_ALLOCATION_FAILURE"},
                               {-5, "CL_OUT_OF_RESOURCES"},       {-6, "CL_OUT_OF_HOST_MEMORY"},
                               {-11, "CL_BUILD_PROGRAM_FAILURE"}, {-30, "CL_INVALID_VALUE"},
                               {-36, "CL_INVALID_COMMAND_QUEUE"}, {-38, "CL_INVALID_MEM_OBJECT"},
                               {-43, "CL_INVALID_BUILD_OPTIONS"}, {-46, "CL_INVALID_KERNEL_NAME"},
                               {-48, "CL_INVALID_KERNEL"},        {-51, "CL_INVALID_ARG_SIZE"},
                               {-52, "CL_INVALID_KERNEL_ARGS"},   {-54, "CL_INVALID_WORK_GROUP_SIZE"},
                               {-61, "CL_INVALID_BUFFER_SIZE"},   {-1001, "CL_PLATFORM_NOT_FOUND_KHR"}};

std::string name_of(cl_int code) {
  for (const CodeName& known : kNames) {
    if (known.code == code) return known.name;
  }
  return fmt::format("OpenCL error {}", code);
}

/// A text property by OpenCL's two calls: its size, then its bytes. query(size, bytes, size_out) is clGet...Info.
template <class Query>
std::string text_of(const char* call, Query query) {
  std::size_t size = 0;
  check_cl(query(0, nullptr, &size), call);
  std::string text(size, '\0');
  check_cl(query(size, text.data(), nullptr), call);
  return text.c_str();  // without the terminating zero
}

std::string platform_text(cl_platform_id platform, cl_platform_info what) {
  return text_of("clGetPlatformInfo", [&](std::size_t size, void* bytes, std::size_t* size_out) {
    return cl().clGetPlatformInfo(platform, what, size, bytes, size_out);
  });
}
std::string platform_name(cl_platform_id platform) { return platform_text(platform, CL_PLATFORM_NAME); }

std::string device_text(cl_device_id device, cl_device_info what) {
  return text_of("clGetDeviceInfo", [&](std::size_t size, void* bytes, std::size_t* size_out) {
    return cl().clGetDeviceInfo(device, what, size, bytes, size_out);
  });
}
std::string device_name(cl_device_id device) { return device_text(device, CL_DEVICE_NAME); }

/// A property that OpenCL has as a Number.
template <class Number>
std::int64_t device_number(cl_device_id device, cl_device_info what) {
  Number number = 0;
  check_cl(cl().clGetDeviceInfo(device, what, sizeof number, &number, nullptr), "clGetDeviceInfo");
  return static_cast<std::int64_t>(number);
}

struct Found {
  std::vector<ClDevice> devices;
  std::vector<OpenClListed> listed;  // the same ones
};

/// A platform without a device is a driver without its card: it is passed over.
Found find_devices() {
  cl_uint count = 0;
  const cl_int code = cl().clGetPlatformIDs(0, nullptr, &count);
  if (code != CL_SUCCESS || count == 0) {
    throw SolverError(SolverFault::unavailable, "no OpenCL platform is installed",
                      "install pocl-opencl-icd (runs OpenCL on the processor), or a GPU's driver");
  }
  std::vector<cl_platform_id> platforms(count);
  check_cl(cl().clGetPlatformIDs(count, platforms.data(), nullptr), "clGetPlatformIDs");
  Found found;
  std::string known;
  for (const cl_platform_id platform : platforms) {
    const std::string name = platform_name(platform);
    known += (known.empty() ? "'" : ", '") + name + "'";
    if (cl().clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS || count == 0) continue;
    std::vector<cl_device_id> devices(count);
    check_cl(cl().clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, devices.data(), nullptr), "clGetDeviceIDs");
    for (const cl_device_id device : devices) {
      const std::string called = device_name(device);
      found.devices.push_back({platform, device, called});
      const std::int64_t type = device_number<cl_device_type>(device, CL_DEVICE_TYPE);
      found.listed.push_back({name, called, (type & CL_DEVICE_TYPE_GPU) != 0});
    }
  }
  if (!found.devices.empty()) return found;
  throw SolverError(SolverFault::unavailable, fmt::format("no OpenCL platform has a device: {}", known),
                    "check its driver; PoCL needs a folder that it can write in POCL_CACHE_DIR, and a driver that it "
                    "knows in POCL_DEVICES");
}

/// Looked for once: a GPU's driver takes a while to wake up.
const Found& found_devices() {
  static const Found found = find_devices();
  return found;
}

}  // namespace

void check_cl(cl_int code, std::string_view call) {
  if (code == CL_SUCCESS) return;
  std::string remedy = "see the OpenCL driver's own messages";
  // PoCL cannot keep compiled kernels: it reports an invalid queue.
  if (code == CL_INVALID_COMMAND_QUEUE) remedy = "with PoCL: set POCL_CACHE_DIR to a folder that can be written";
  const bool memory =
      code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_RESOURCES || code == CL_OUT_OF_HOST_MEMORY;
  throw SolverError(memory ? SolverFault::out_of_memory : SolverFault::unavailable,
                    fmt::format("{} failed: {}", call, name_of(code)), remedy);
}

ClDevice choose_device(const SolverOptions& options) {
  const Found& found = found_devices();
  return found.devices[choose_opencl(found.listed, options.opencl_device, options.prefer_gpu)];
}

OpenClDescription describe(const ClDevice& device) {
  return {.device = device.name,
          .platform = platform_name(device.platform),
          .version = platform_text(device.platform, CL_PLATFORM_VERSION),
          .driver = device_text(device.device, CL_DRIVER_VERSION),
          .compute_units = device_number<cl_uint>(device.device, CL_DEVICE_MAX_COMPUTE_UNITS),
          .clock_MHz = device_number<cl_uint>(device.device, CL_DEVICE_MAX_CLOCK_FREQUENCY),
          .timer_resolution_ns = device_number<std::size_t>(device.device, CL_DEVICE_PROFILING_TIMER_RESOLUTION),
          .memory_bytes = device_number<cl_ulong>(device.device, CL_DEVICE_GLOBAL_MEM_SIZE)};
}

}  // namespace evenstep::internal

const std::vector<evenstep::OpenClListed>& evenstep::opencl_devices() { return evenstep::internal::found_devices().listed; }
