// The real solver: the kernels of opencl/kernels, bit for bit equal to cpu/tissue_solver.cpp in float.
#include "src/tissue_solver.h"

#include <fmt/format.h>

#include <mutex>
#include <vector>

#include "evenstep/time/digest.h"
#include "opencl/cl_handle.h"
#include "opencl/opencl_solver.h"
#include "opencl_kernels.h"

namespace evenstep::internal {
namespace {

/// "%a" is exact; a decimal rendering of 20.0f is not even a float literal.
std::string hex(float value) { return fmt::format("{:a}f", value); }

std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, bool variable_step,
                          cl_device_id device) {
  std::string springs;
  for (std::size_t s = 0; s < kNeighbours; ++s) {
    const auto& [x, y, z] = constants.rest_m[s];
    springs += fmt::format("S({},{},{},{},{})", lattice.offset[s], hex(x), hex(y), hex(z), hex(constants.length_m[s]));
  }
  std::string options = fmt::format(
      "-DSPRINGS(S)={} -DSTIFFNESS={} -DHALF_MASS={} -DQUARTER_STIFFNESS={} -DFIRST={}UL -DCHUNK={}", springs,
      hex(constants.stiffness_N_per_m), hex(constants.half_mass_kg), hex(constants.quarter_stiffness_N_per_m),
      lattice.first, kChunk);
  if (variable_step) {
    options += " -DVARIABLE_STEP";
  } else {
    options += fmt::format(" -DSTEP={} -DACCELERATION={} -DDECAY={}", hex(constants.step_s),
                           hex(constants.acceleration), hex(constants.decay));
  }
  cl_device_fp_config config = 0;
  check_cl(clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof config, &config, nullptr), "clGetDeviceInfo");
  // GPUs default to 2.5 to 3 ulp for / and sqrt.
  if (config & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) options += " -cl-fp32-correctly-rounded-divide-sqrt";
  return options;
}

struct ClField {
  const ClBuffer& axis(int n) const { return n == 0 ? x : n == 1 ? y : z; }
  ClBuffer x, y, z;
};

/// Asked before anything is allocated: some drivers grant more than they have, and fail at the first launch.
void check_memory(const Scene& scene, const ClDevice& device) {
  cl_ulong there = 0, largest = 0;
  check_cl(clGetDeviceInfo(device.device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof there, &there, nullptr), "clGetDeviceInfo");
  check_cl(clGetDeviceInfo(device.device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof largest, &largest, nullptr),
           "clGetDeviceInfo");
  // 9 fields, 2 masks and perhaps the energies of 4 bytes, perhaps the digests of 8.
  const double one = cells_of(std::get<TissueScene>(scene.body)) * (scene.needs_state_digest ? 8 : 4);
  const double needed =
      cells_of(std::get<TissueScene>(scene.body)) * (44 + (scene.needs_energy ? 4 : 0) + (scene.needs_state_digest ? 8 : 0));
  if (needed <= static_cast<double>(there) && one <= static_cast<double>(largest)) return;
  throw SolverError(
      SolverFault::out_of_memory,
      fmt::format("the scene needs {:.3g} bytes of device memory ({:.3g} in one piece), '{}' has {:.3g} ({:.3g})", needed,
                  one, device.name, static_cast<double>(there), static_cast<double>(largest)),
      "fewer particles, or another device");
}

class OpenClTissue final : public TissueSolver {
 public:
  OpenClTissue(const Scene& given, const SolverOptions& options, ClDevice device)
      : TissueSolver(given, "opencl"),
        constants_(scene(), substep_s()),
        local_size_(static_cast<std::size_t>(options.work_group_size)),
        device_(std::move(device)) {
    open();
    build();
    allocate();
    bind();
    warm_up();
  }

 protected:
  void substep(std::span<const GrabTarget> targets) override {
    enqueue(advance_[current_], lattice().span);
    current_ = 1 - current_;
    if (grabbed_count() == 0) return;
    const cl_kernel kernel = grab_[current_].get();
    for (std::size_t tool = 0; tool < targets.size(); ++tool) {
      const auto& [u, v] = targets[tool];
      const cl_float4 offset{{static_cast<float>(u[0]), static_cast<float>(u[1]), static_cast<float>(u[2]), 0}};
      const cl_float4 velocity{{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0}};
      const cl_uint first_argument = 3 + 2 * static_cast<cl_uint>(tool);
      set(kernel, first_argument, offset);
      set(kernel, first_argument + 1, velocity);
    }
    enqueue(grab_[current_], padded_grabs());
  }

  void set_substep(double substep_s) override {
    constants_.set_substep(scene(), substep_s);
    bind_substep();
  }

  void grab_forces(std::span<std::array<double, 3>> forces_N) override {
    if (forces_N.empty()) {
      check_cl(clFinish(queue_.get()), "clFinish");
      return;
    }
    enqueue(grab_force_[current_], padded_grabs());
    force_staging_.resize(3 * forces_N.size());
    read(grab_force_buffer_, force_staging_.size() * sizeof(float), force_staging_.data());
    for (std::size_t n = 0; n < forces_N.size(); ++n) {
      forces_N[n] = {force_staging_[3 * n], force_staging_[3 * n + 1], force_staging_[3 * n + 2]};
    }
  }

  std::uint64_t digest() override {
    enqueue(cell_digest_[current_], lattice().span);
    enqueue(chunk_digest_, chunks());
    std::vector<std::uint64_t> sums(chunks());
    read(chunk_sums_, sums.size() * sizeof(std::uint64_t), sums.data());
    std::uint64_t digest = kDigestStart;
    for (const std::uint64_t sum : sums) digest = mix(digest, sum);
    return digest;
  }

  double energy() override {
    enqueue(cell_energy_[current_], lattice().span);
    enqueue(chunk_energy_, chunks());
    std::vector<float> sums(chunks());
    read(energy_sums_, sums.size() * sizeof(float), sums.data());
    double total = 0;
    for (const float sum : sums) total += sum;
    return total;
  }

  void to_rest() override {
    const float zero = 0;
    for (const ClField* field : {&displacement_[0], &displacement_[1], &velocity_}) {
      for (const ClBuffer* component : {&field->x, &field->y, &field->z}) {
        check_cl(clEnqueueFillBuffer(queue_.get(), component->get(), &zero, sizeof zero, 0, lattice().cells * sizeof(float),
                                     0, nullptr, nullptr),
                 "clEnqueueFillBuffer");
      }
    }
    check_cl(clFinish(queue_.get()), "clFinish");
  }

  void put_state(const ParticleState& state) override {
    std::vector<float> cells(lattice().cells);
    const auto put = [&](const ClBuffer& to, const std::vector<glm::dvec3>& from, int axis) {
      for (std::size_t n = 0; n < from.size(); ++n)
        cells[lattice().cell(static_cast<std::int64_t>(n))] = static_cast<float>(from[n][axis]);
      check_cl(clEnqueueWriteBuffer(queue_.get(), to.get(), CL_TRUE, 0, cells.size() * sizeof(float), cells.data(), 0, nullptr,
                                    nullptr),
               "clEnqueueWriteBuffer");
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (const ClField* field : {&displacement_[0], &displacement_[1]}) put(field->axis(axis), state.displacement_m, axis);
      put(velocity_.axis(axis), state.velocity_m_per_s, axis);
    }
  }

  void read_state(ParticleState& state) override {
    std::vector<float> cells(lattice().cells);
    const auto get = [&](const ClBuffer& from, std::vector<glm::dvec3>& to, int axis) {
      read(from, cells.size() * sizeof(float), cells.data());
      for (std::size_t n = 0; n < to.size(); ++n) to[n][axis] = cells[lattice().cell(static_cast<std::int64_t>(n))];
    };
    for (int axis = 0; axis < 3; ++axis) {
      get(displacement_[current_].axis(axis), state.displacement_m, axis);
      get(velocity_.axis(axis), state.velocity_m_per_s, axis);
    }
  }

 private:
  std::size_t chunks() const { return lattice().span / kChunk; }
  std::size_t padded_grabs() const { return (grabbed_count() + local_size_ - 1) / local_size_ * local_size_; }

  void open() {
    set_device(device_.name);
    cl_int code = CL_SUCCESS;
    const cl_context_properties properties[] = {CL_CONTEXT_PLATFORM,
                                                reinterpret_cast<cl_context_properties>(device_.platform), 0};
    context_ = ClContext(clCreateContext(properties, 1, &device_.device, nullptr, nullptr, &code));
    check_cl(code, "clCreateContext");
    queue_ = ClQueue(clCreateCommandQueue(context_.get(), device_.device, 0, &code));  // in order
    check_cl(code, "clCreateCommandQueue");
  }

  void build() {
    std::string source = kSpringsSource;
    source += kAdvanceSource;
    if (grabbed_count() > 0) source += std::string(kGrabSource) + kGrabForceSource;
    if (needs_digest()) source += kDigestSource;
    if (needs_energy()) source += kEnergySource;
    const char* text = source.c_str();
    cl_int code = CL_SUCCESS;
    program_ = ClProgram(clCreateProgramWithSource(context_.get(), 1, &text, nullptr, &code));
    check_cl(code, "clCreateProgramWithSource");
    const std::string options = build_options(constants_, lattice(), variable_step(), device_.device);
    code = clBuildProgram(program_.get(), 1, &device_.device, options.c_str(), nullptr, nullptr);
    if (code == CL_BUILD_PROGRAM_FAILURE) {
      std::size_t size = 0;
      clGetProgramBuildInfo(program_.get(), device_.device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
      std::string log(size, '\0');
      clGetProgramBuildInfo(program_.get(), device_.device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
      throw SolverError(
          SolverFault::unavailable, "the OpenCL kernels do not build: " + std::string(log.c_str()),
          "with PoCL: set POCL_CACHE_DIR to a folder that can be written; otherwise report it with the device's name");
    }
    check_cl(code, "clBuildProgram");
  }

  ClBuffer buffer(std::size_t bytes, const void* content = nullptr) {
    cl_int code = CL_SUCCESS;
    const cl_mem_flags flags = CL_MEM_READ_WRITE | (content ? CL_MEM_COPY_HOST_PTR : 0);
    ClBuffer result(clCreateBuffer(context_.get(), flags, bytes, const_cast<void*>(content), &code));
    check_cl(code, "clCreateBuffer");
    return result;
  }
  ClField field() {
    const std::size_t bytes = lattice().cells * sizeof(float);
    return {buffer(bytes), buffer(bytes), buffer(bytes)};
  }

  void allocate() {
    displacement_[0] = field();
    displacement_[1] = field();
    velocity_ = field();
    const std::vector<float> active(lattice().active.begin(), lattice().active.end());
    const std::vector<float> mobile(lattice().mobile.begin(), lattice().mobile.end());
    active_ = buffer(active.size() * sizeof(float), active.data());
    mobile_ = buffer(mobile.size() * sizeof(float), mobile.data());
    if (grabbed_count() > 0) {
      std::vector<cl_uint> cells;
      for (const auto& tool : lattice().held) cells.insert(cells.end(), tool.begin(), tool.end());
      grabbed_ = buffer(cells.size() * sizeof(cl_uint), cells.data());
      grab_force_buffer_ = buffer(3 * cells.size() * sizeof(float));
    }
    if (needs_digest()) {
      cell_digests_ = buffer(lattice().span * sizeof(cl_ulong));
      chunk_sums_ = buffer(chunks() * sizeof(cl_ulong));
    }
    if (needs_energy()) {
      cell_energies_ = buffer(lattice().span * sizeof(float));
      energy_sums_ = buffer(chunks() * sizeof(float));
    }
  }

  /// Two kernels of each kind, one per direction of the ping-pong, with their buffers set once.
  void bind() {
    for (std::size_t from = 0; from < 2; ++from) {
      const ClField& now = displacement_[from];
      const ClField& next = displacement_[1 - from];
      advance_[from] = kernel("advance", now.x, now.y, now.z, next.x, next.y, next.z, velocity_.x, velocity_.y, velocity_.z,
                              active_, mobile_);
      if (grabbed_count() > 0) {
        const cl_uint count = static_cast<cl_uint>(grabbed_count()),
                      split = static_cast<cl_uint>(lattice().held[0].size());
        const cl_float4 none{};
        grab_[from] = kernel("grab", grabbed_, count, split, none, none, none, none, now.x, now.y, now.z, velocity_.x,
                             velocity_.y, velocity_.z);
        grab_force_[from] = kernel("grab_force", grabbed_, count, now.x, now.y, now.z, active_, grab_force_buffer_);
      }
      if (needs_digest())
        cell_digest_[from] =
            kernel("cell_digest", now.x, now.y, now.z, velocity_.x, velocity_.y, velocity_.z, cell_digests_);
      if (needs_energy())
        cell_energy_[from] = kernel("cell_energy", now.x, now.y, now.z, velocity_.x, velocity_.y, velocity_.z, active_,
                                    mobile_, cell_energies_);
    }
    if (variable_step()) bind_substep();
    if (needs_digest()) chunk_digest_ = kernel("chunk_digest", cell_digests_, chunk_sums_);
    if (needs_energy()) chunk_energy_ = kernel("chunk_energy", cell_energies_, energy_sums_);
  }

  /// The substep's length is an argument only of kernels built for one that varies (advance.cl).
  void bind_substep() {
    constexpr cl_uint first_argument = 11;
    for (const ClKernel& advance : advance_) {
      set(advance.get(), first_argument, constants_.step_s);
      set(advance.get(), first_argument + 1, constants_.acceleration);
      set(advance.get(), first_argument + 2, constants_.decay);
    }
  }

  /// PoCL compiles a kernel at its first launch (up to 250 ms), so every kernel runs before t = 0.
  void warm_up() {
    to_rest();
    const std::array<GrabTarget, kMaxTools> nowhere{};
    for (int direction = 0; direction < 2; ++direction) {
      substep(std::span(nowhere.data(), lattice().held.size()));
      std::vector<std::array<double, 3>> ignored(grabbed_count());
      grab_forces(ignored);
      if (needs_digest()) digest();
      if (needs_energy()) energy();
    }
    to_start();
  }

  void set(cl_kernel kernel, cl_uint index, const ClBuffer& argument) {
    const cl_mem memory = argument.get();
    set(kernel, index, memory);
  }
  template <class Argument>
  void set(cl_kernel kernel, cl_uint index, const Argument& argument) {
    check_cl(clSetKernelArg(kernel, index, sizeof argument, &argument), "clSetKernelArg");
  }
  template <class... Arguments>
  ClKernel kernel(const char* name, const Arguments&... arguments) {
    cl_int code = CL_SUCCESS;
    ClKernel result(clCreateKernel(program_.get(), name, &code));
    check_cl(code, fmt::format("clCreateKernel({})", name));
    cl_uint index = 0;
    (set(result.get(), index++, arguments), ...);
    return result;
  }
  /// `count` is a multiple of the work-group size, except for the few chunk sums.
  void enqueue(const ClKernel& kernel, std::size_t count) {
    const std::size_t* local = count % local_size_ == 0 ? &local_size_ : nullptr;
    check_cl(clEnqueueNDRangeKernel(queue_.get(), kernel.get(), 1, nullptr, &count, local, 0, nullptr, nullptr),
             "clEnqueueNDRangeKernel");
  }
  void read(const ClBuffer& from, std::size_t bytes, void* to) {
    check_cl(clEnqueueReadBuffer(queue_.get(), from.get(), CL_TRUE, 0, bytes, to, 0, nullptr, nullptr),
             "clEnqueueReadBuffer");
  }

  TissueConstants<float> constants_;
  std::size_t local_size_;
  ClDevice device_;
  ClContext context_;
  ClQueue queue_;
  ClProgram program_;
  std::array<ClField, 2> displacement_;  // from rest, m; current_ is the newest
  ClField velocity_;
  ClBuffer active_, mobile_, grabbed_, grab_force_buffer_, cell_digests_, chunk_sums_, cell_energies_, energy_sums_;
  std::array<ClKernel, 2> advance_, grab_, grab_force_, cell_digest_, cell_energy_;  // [c] reads displacement_[c]
  ClKernel chunk_digest_, chunk_energy_;
  std::vector<float> force_staging_;
  std::size_t current_ = 0;
};

}  // namespace

/// PoCL 3.1 corrupts itself when two threads look for devices, or build and first launch the same program, at once (seen: no
/// device, CL_INVALID_KERNEL_NAME, crashes), so the solvers of a process are made one after the other.
std::unique_ptr<Solver> make_opencl_tissue(const Scene& scene, const SolverOptions& options) {
  check_tissue(std::get<TissueScene>(scene.body), scene.tool_count);
  if (options.work_group_size < 1 || kChunk % static_cast<std::size_t>(options.work_group_size) != 0) {
    throw SolverError(SolverFault::bad_scene, fmt::format("a work-group size of {}", options.work_group_size),
                      fmt::format("a divisor of {}", kChunk));
  }
  static std::mutex making;
  const std::lock_guard one_at_a_time(making);
  ClDevice device = choose_device(options.opencl_platform, options.opencl_device);
  check_memory(scene, device);
  return std::make_unique<OpenClTissue>(scene, options, std::move(device));
}

}  // namespace evenstep::internal
