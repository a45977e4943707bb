#include "opencl/cl_commands.h"

#include <fmt/format.h>

#include "evenstep/sim/solver.h"

namespace evenstep::internal {

ClCommands::ClCommands(ClDevice device, std::size_t local_size, bool logged)
    : device_(std::move(device)), local_size_(local_size), log_(logged ? std::make_unique<ClCommandLog>() : nullptr) {
  cl_int code = CL_SUCCESS;
  const cl_context_properties properties[] = {CL_CONTEXT_PLATFORM, reinterpret_cast<cl_context_properties>(device_.platform),
                                              0};
  context_ = ClContext(cl().clCreateContext(properties, 1, &device_.device, nullptr, nullptr, &code));
  check_cl(code, "clCreateContext");
  queue_ = ClQueue(cl().clCreateCommandQueue(context_.get(), device_.device, logged ? CL_QUEUE_PROFILING_ENABLE : 0, &code));
  check_cl(code, "clCreateCommandQueue");
}

void ClCommands::build(const std::string& source, const std::string& options) {
  const char* text = source.c_str();
  cl_int code = CL_SUCCESS;
  ClProgram program(cl().clCreateProgramWithSource(context_.get(), 1, &text, nullptr, &code));
  check_cl(code, "clCreateProgramWithSource");
  code = cl().clBuildProgram(program.get(), 1, &device_.device, options.c_str(), nullptr, nullptr);
  if (code == CL_BUILD_PROGRAM_FAILURE) {
    throw SolverError(
        SolverFault::unavailable, "the OpenCL kernels do not build: " + build_log(program.get()),
        "with PoCL: set POCL_CACHE_DIR to a folder that can be written; otherwise report it with the device's name");
  }
  check_cl(code, "clBuildProgram");
  programs_.push_back(std::move(program));
}

std::string ClCommands::build_log(cl_program program) const {
  std::size_t size = 0;
  cl().clGetProgramBuildInfo(program, device_.device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
  std::string log(size, '\0');
  cl().clGetProgramBuildInfo(program, device_.device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
  return log.c_str();  // up to its first zero
}

BoundKernel ClCommands::kernel(const char* name) const {
  cl_int code = CL_INVALID_KERNEL_NAME;
  ClKernel kernel;
  for (auto program = programs_.begin(); code == CL_INVALID_KERNEL_NAME && program != programs_.end(); ++program)
    kernel = ClKernel(cl().clCreateKernel(program->get(), name, &code));
  check_cl(code, fmt::format("clCreateKernel({})", name));
  return {std::move(kernel), name};
}

void ClCommands::enqueue(const BoundKernel& kernel, std::size_t count) const {
  const std::size_t* local = count % local_size_ == 0 ? &local_size_ : nullptr;
  enqueue_one("clEnqueueNDRangeKernel", kernel.name(), [&](cl_event* event) {
    return cl().clEnqueueNDRangeKernel(queue_.get(), kernel.get(), 1, nullptr, &count, local, 0, nullptr, event);
  });
}

void ClCommands::finish() const { check_cl(cl().clFinish(queue_.get()), "clFinish"); }

ClBuffer ClCommands::new_buffer(cl_mem_flags flags, std::size_t bytes, const void* content) const {
  cl_int code = CL_SUCCESS;
  ClBuffer result(cl().clCreateBuffer(context_.get(), flags, bytes, const_cast<void*>(content), &code));
  check_cl(code, "clCreateBuffer");
  return result;
}

ClBuffer ClCommands::buffer(std::size_t bytes, const void* content) const {
  return new_buffer(CL_MEM_READ_WRITE | (content ? CL_MEM_COPY_HOST_PTR : 0), bytes, content);
}

ClBuffer ClCommands::shared_buffer(std::size_t bytes) const {
  return new_buffer(CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, bytes, nullptr);
}

ClField ClCommands::field(std::size_t cells) const {
  const std::size_t bytes = cells * sizeof(float);
  return {buffer(bytes), buffer(bytes), buffer(bytes)};
}

void ClCommands::read(const ClBuffer& from, std::size_t bytes, void* to) const {
  enqueue_one("clEnqueueReadBuffer", "read", [&](cl_event* event) {
    return cl().clEnqueueReadBuffer(queue_.get(), from.get(), CL_TRUE, 0, bytes, to, 0, nullptr, event);
  });
}

void* ClCommands::map(const ClBuffer& from, std::size_t bytes) const {
  void* mapped = nullptr;
  enqueue_one("clEnqueueMapBuffer", "map", [&](cl_event* event) {
    cl_int code = CL_SUCCESS;
    mapped = cl().clEnqueueMapBuffer(queue_.get(), from.get(), CL_TRUE, CL_MAP_READ, 0, bytes, 0, nullptr, event, &code);
    return code;
  });
  return mapped;
}

void ClCommands::unmap(const ClBuffer& buffer, void* mapped) const {
  enqueue_one("clEnqueueUnmapMemObject", "unmap", [&](cl_event* event) {
    return cl().clEnqueueUnmapMemObject(queue_.get(), buffer.get(), mapped, 0, nullptr, event);
  });
}

void ClCommands::write(const void* from, std::size_t bytes, const ClBuffer& to) const {
  enqueue_one("clEnqueueWriteBuffer", "write", [&](cl_event* event) {
    return cl().clEnqueueWriteBuffer(queue_.get(), to.get(), CL_TRUE, 0, bytes, from, 0, nullptr, event);
  });
}

void ClCommands::zero(const ClBuffer& buffer, std::size_t bytes) const {
  const float zero = 0;
  enqueue_one("clEnqueueFillBuffer", "fill", [&](cl_event* event) {
    return cl().clEnqueueFillBuffer(queue_.get(), buffer.get(), &zero, sizeof zero, 0, bytes, 0, nullptr, event);
  });
}

void ClCommands::copy(const ClBuffer& from, const ClBuffer& to, std::size_t bytes) const {
  enqueue_one("clEnqueueCopyBuffer", "copy", [&](cl_event* event) {
    return cl().clEnqueueCopyBuffer(queue_.get(), from.get(), to.get(), 0, 0, bytes, 0, nullptr, event);
  });
}

std::span<const float> ClResults::read() {
  give_back();
  mapped_ = commands_->map(buffer_, size_ * sizeof(float));
  return {static_cast<const float*>(mapped_), size_};
}

void ClResults::give_back() {
  if (mapped_ != nullptr) commands_->unmap(buffer_, std::exchange(mapped_, nullptr));
}

ClResults::~ClResults() {
  try {
    give_back();
  } catch (const SolverError&) {  // the device is gone, and so is its memory
  }
}

}  // namespace evenstep::internal
