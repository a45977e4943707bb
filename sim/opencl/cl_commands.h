#pragma once
/// Context, program and in-order queue of one device, and kernels with their arguments.

#include <array>
#include <cstddef>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
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
  /// The driver is told only of values that change: the call costs as much as the rest of a launch.
  template <class Value>
  void set(cl_uint index, const Value& value) {
    Bytes bytes{};
    static_assert(sizeof value <= sizeof bytes);
    std::memcpy(bytes.data(), &value, sizeof value);
    if (index >= given_.size()) given_.resize(index + 1);
    if (given_[index] == bytes) return;
    check_cl(cl().clSetKernelArg(kernel_.get(), index, sizeof value, &value), "clSetKernelArg");
    given_[index] = bytes;
  }
  /// The index of the argument that is added next.
  cl_uint next() const { return arguments_; }

  cl_uint tools_at = 0, grabs_at = 0, step_at = 0;

 private:
  void add_one(const ClField& field) { add(field.x, field.y, field.z); }
  void add_one(const ClBuffer& buffer) { add_one(buffer.get()); }
  template <class Value>
  void add_one(const Value& value) {
    set(arguments_++, value);
  }

  using Bytes = std::array<std::byte, sizeof(cl_float4)>;

  ClKernel kernel_;
  std::vector<std::optional<Bytes>> given_;  // the arguments that the driver has
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
  /// A buffer in memory that the host sees, too, where the device can reach that.
  ClBuffer shared_buffer(std::size_t bytes) const;
  /// Waits for all that was given to the queue before. The bytes are the host's until unmap(); no kernel may write to the
  /// buffer until then.
  void* map(const ClBuffer& from, std::size_t bytes) const;
  void unmap(const ClBuffer& buffer, void* mapped) const;
  void copy(const ClBuffer& from, const ClBuffer& to, std::size_t bytes) const;

 private:
  /// Gives the queue one command: give(event) is clEnqueue..., with an event that is null if no log is kept.
  template <class Give>
  void enqueue_one(const char* call, const char* name, Give give) const {
    cl_event event = nullptr;
    check_cl(give(log_ ? &event : nullptr), call);
    if (log_) log_->add(name, ClEvent(event));
  }
  ClBuffer new_buffer(cl_mem_flags flags, std::size_t bytes, const void* content) const;
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

/// Values that kernels write and the host reads after every step, without a copy in between.
class ClResults {
 public:
  ClResults() = default;
  ClResults(const ClCommands& commands, std::size_t size) : commands_(&commands), size_(size) {
    if (size > 0) buffer_ = commands.shared_buffer(size * sizeof(float));
  }
  ClResults(ClResults&& other) noexcept { *this = std::move(other); }
  ClResults& operator=(ClResults&& other) noexcept {
    std::swap(commands_, other.commands_);
    std::swap(size_, other.size_);
    std::swap(mapped_, other.mapped_);
    buffer_ = std::move(other.buffer_);
    return *this;
  }
  ~ClResults();
  const ClBuffer& buffer() const { return buffer_; }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  /// Waits for the kernels before it. Valid until give_back(), which must come before the next kernel that writes here:
  /// then, and not earlier, because by then the device has work again that hides it.
  std::span<const float> read();
  void give_back();

 private:
  const ClCommands* commands_ = nullptr;
  std::size_t size_ = 0;
  void* mapped_ = nullptr;
  ClBuffer buffer_;
};

}  // namespace evenstep::internal
