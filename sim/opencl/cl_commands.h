#pragma once
/// Context, program and in-order queue of one device, and kernels with their arguments.

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "opencl/cl_command_log.h"
#include "opencl/cl_handle.h"

namespace evenstep::internal {

/// Structure of arrays, one entry per cell.
struct ClField {
  const ClBuffer& axis(int n) const { return n == 0 ? x : n == 1 ? y : z; }
  ClBuffer x, y, z;
};

/// A kernel and its arguments: first those that never change, in the order of its parameters, then those that depend on the
/// tools and the substep. Null until ClCommands makes it.
class BoundKernel {
 public:
  BoundKernel() = default;
  BoundKernel(ClKernel kernel, const char* name) : kernel_(std::move(kernel)), name_(name) {}
  explicit operator bool() const { return kernel_.get() != nullptr; }
  cl_kernel get() const { return kernel_.get(); }
  const char* name() const { return name_; }

  template <class... Arguments>
  void add(const Arguments&... arguments) {
    (add_one(arguments), ...);
  }
  template <class Value>
  void set(cl_uint index, const Value& value) const {
    check_cl(cl().clSetKernelArg(kernel_.get(), index, sizeof value, &value), "clSetKernelArg");
  }
  /// The index of the argument that is added next.
  cl_uint next() const { return arguments_; }

  cl_uint tools_at = 0, step_at = 0;

 private:
  void add_one(const ClField& field) { add(field.x, field.y, field.z); }
  void add_one(const ClBuffer& buffer) { add_one(buffer.get()); }
  template <class Value>
  void add_one(const Value& value) {
    set(arguments_++, value);
  }

  ClKernel kernel_;
  const char* name_ = "";
  cl_uint arguments_ = 0;
};

/// Every call throws SolverError if the OpenCL call fails. Reads and writes block.
class ClCommands {
 public:
  /// `logged`: keeps a profiling event of each command, for log().
  ClCommands(ClDevice device, std::size_t local_size, bool logged = false);
  /// Adds a program. No two programs may have kernels of the same name.
  void build(const std::string& source, const std::string& options);
  const ClDevice& device() const { return device_; }
  ClCommandLog* log() const { return log_.get(); }  ///< null if none is kept

  /// From whichever program has this kernel. `name` must be valid as long as the process runs.
  BoundKernel kernel(const char* name) const;
  /// `count` is a multiple of the work-group size, except for the sums over chunks, which are few.
  void enqueue(const BoundKernel& kernel, std::size_t count) const;
  std::size_t padded(std::size_t count) const { return (count + local_size_ - 1) / local_size_ * local_size_; }
  bool is_one_group(std::size_t count) const { return count <= local_size_; }
  void finish() const;

  ClBuffer buffer(std::size_t bytes, const void* content = nullptr) const;
  template <class Value>
  ClBuffer buffer_of(const std::vector<Value>& content) const {
    return buffer(content.size() * sizeof(Value), content.data());
  }
  ClField field(std::size_t cells) const;
  template <class Value>
  void read(const ClBuffer& from, std::vector<Value>& to) const {
    read(from, to.size() * sizeof(Value), to.data());
  }
  template <class Value>
  void write(const std::vector<Value>& from, const ClBuffer& to) const {
    write(from.data(), from.size() * sizeof(Value), to);
  }
  void zero(const ClBuffer& buffer, std::size_t bytes) const;
  void copy(const ClBuffer& from, const ClBuffer& to, std::size_t bytes) const;

 private:
  /// Gives the queue one command: give(event) is clEnqueue..., with an event that is null if no log is kept.
  template <class Give>
  void enqueue_one(const char* call, const char* name, Give give) const {
    cl_event event = nullptr;
    check_cl(give(log_ ? &event : nullptr), call);
    if (log_) log_->add(name, ClEvent(event));
  }
  void read(const ClBuffer& from, std::size_t bytes, void* to) const;
  void write(const void* from, std::size_t bytes, const ClBuffer& to) const;
  std::string build_log(cl_program program) const;

  ClDevice device_;
  std::size_t local_size_;
  ClContext context_;
  ClQueue queue_;
  std::vector<ClProgram> programs_;
  std::unique_ptr<ClCommandLog> log_;
};

}  // namespace evenstep::internal
