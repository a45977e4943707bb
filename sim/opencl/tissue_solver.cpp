// The real solver: the kernels of opencl/kernels, bit for bit equal to cpu/tissue_solver.cpp in float.
#include "src/tissue_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <vector>

#include "cpu/methods/implicit_system.h"
#include "evenstep/time/digest.h"
#include "opencl/cl_handle.h"
#include "opencl/opencl_solver.h"
#include "opencl_kernels.h"
#include "src/iterations.h"

namespace evenstep::internal {
namespace {

/// "%a" is exact; a decimal rendering of 20.0f is not even a float literal.
std::string hex(float value) { return fmt::format("{:a}f", value); }

/// Every spring, coupling and probe with its constants, as arguments of macros (kernels/springs.cl).
std::string tissue_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features) {
  std::string springs, couplings, probes;
  for (std::size_t s = 0; s < kNeighbours; ++s) {
    const auto& [x, y, z] = constants.rest_m[s];
    springs += fmt::format("S({},{},{},{},{},{})", lattice.offset[s], hex(x), hex(y), hex(z), hex(constants.length_m[s]),
                           hex(constants.axial_s_per_m2[s]));
  }
  for (std::size_t t = 0; t < kMaxTools; ++t) {
    const ToolConstants<float>& tool = constants.tools[t];
    const auto& [x, y, z] = tool.center_m;
    if (features.spring[t])
      couplings += fmt::format("C({},{},{},{})", t, hex(tool.stiffness), hex(tool.damping_s),
                               hex(tool.half_stiffness_N_per_m));
    if (features.probe[t])
      probes += fmt::format("P({},{},{},{},{},{},{})", t, hex(tool.stiffness), hex(tool.half_stiffness_N_per_m),
                            hex(tool.radius_m), hex(x), hex(y), hex(z));
  }
  std::string options = "-DSPRINGS(S)=" + springs;
  if (!couplings.empty()) options += " -DCOUPLINGS(C)=" + couplings;
  if (features.spring[0]) options += " -DHELD0";
  if (features.spring[1]) options += " -DHELD1";
  if (!probes.empty()) options += " -DPROBED -DPROBES(P)=" + probes;
  return options;
}

std::string build_options(const TissueConstants<float>& constants, const Lattice& lattice, const SceneFeatures& features,
                          cl_device_id device) {
  std::string options = tissue_options(constants, lattice, features);
  options += fmt::format(
      " -DSTIFFNESS={} -DSTIFFNESS_PER_KG={} -DHALF_MASS={} -DQUARTER_STIFFNESS={} -DFIRST={}UL -DCHUNK={}",
      hex(constants.stiffness_N_per_m), hex(constants.stiffness_per_kg), hex(constants.half_mass_kg),
      hex(constants.quarter_stiffness_N_per_m), lattice.first, kChunk);
  const auto vector = [](const char* name, const std::array<float, 3>& v) {
    return fmt::format(" -D{0}_x={1} -D{0}_y={2} -D{0}_z={3}", name, hex(v[0]), hex(v[1]), hex(v[2]));
  };
  if (features.regions) options += " -DREGIONS";
  if (features.axial_damping) options += " -DAXIAL_DAMPING";
  if (features.damping) options += " -DDAMPING -DDAMPING_PER_S=" + hex(constants.damping_per_s);
  if (features.gravity)
    options += " -DGRAVITY" + vector("GRAVITY", constants.gravity_m_per_s2) + vector("WEIGHT", constants.weight_N);
  if (features.local_model) options += " -DLOCAL_MODEL";
  if (features.variable_step) {
    options += " -DVARIABLE_STEP";
  } else {
    options += fmt::format(" -DSTEP={} -DHALF_STEP={} -DACCELERATION={} -DDECAY={}", hex(constants.step_s),
                           hex(constants.half_step_s), hex(constants.acceleration), hex(constants.decay));
    if (features.gravity) options += vector("STEP_GRAVITY", constants.gravity);
  }
  cl_device_fp_config config = 0;
  check_cl(clGetDeviceInfo(device, CL_DEVICE_SINGLE_FP_CONFIG, sizeof config, &config, nullptr), "clGetDeviceInfo");
  // GPUs default to 2.5 to 3 ulp for / and sqrt.
  if (config & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) options += " -cl-fp32-correctly-rounded-divide-sqrt";
  return options;
}

/// What the kernels of implicit Euler need always, be it neutral.
std::string implicit_options(const TissueConstants<float>& constants, const SceneFeatures& features) {
  const auto& [x, y, z] = constants.gravity_m_per_s2;
  const bool general = features.regions || features.axial_damping || features.tool_forces();
  return fmt::format(" -DDRAG_PER_S={} -DFALL_x={} -DFALL_y={} -DFALL_z={}{}", hex(constants.damping_per_s), hex(x), hex(y),
                     hex(z), general ? " -DGENERAL_SYSTEM" : "");
}

struct ClField {
  const ClBuffer& axis(int n) const { return n == 0 ? x : n == 1 ? y : z; }
  ClBuffer x, y, z;
};

/// One kernel with its arguments: those that never change in order, then what the tools and the substep set.
struct BoundKernel {
  ClKernel kernel;
  cl_uint arguments = 0;
  cl_uint tools_at = 0, step_at = 0;
};

/// Asked before anything is allocated: some drivers grant more than they have, and fail at the first launch.
void check_memory(const Scene& scene, const SceneFeatures& features, const ClDevice& device) {
  cl_ulong there = 0, largest = 0;
  check_cl(clGetDeviceInfo(device.device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof there, &there, nullptr), "clGetDeviceInfo");
  check_cl(clGetDeviceInfo(device.device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof largest, &largest, nullptr),
           "clGetDeviceInfo");
  const auto& tissue = std::get<TissueScene>(scene.body);
  const double digest_bytes = features.digest ? sizeof(cl_ulong) : 0;
  const double probe_bytes = features.probes() ? static_cast<double>(sizeof(float) * features.probe_values()) : 0;
  const double one = cells_of(tissue) * std::max({double{sizeof(float)}, digest_bytes, probe_bytes});
  const double needed = cells_of(tissue) * (double{sizeof(float)} * scalar_arrays(features, tissue.method) + digest_bytes +
                                            probe_bytes);
  if (needed <= static_cast<double>(there) && one <= static_cast<double>(largest)) return;
  throw SolverError(
      SolverFault::out_of_memory,
      fmt::format("the scene needs {:.3g} bytes of device memory ({:.3g} in one piece), '{}' has {:.3g} ({:.3g})", needed,
                  one, device.name, static_cast<double>(there), static_cast<double>(largest)),
      "fewer particles, or another device");
}

class OpenClTissue final : public TissueSolver {
 public:
  OpenClTissue(const Scene& given, const SceneFeatures& features, const SolverOptions& options, ClDevice device)
      : TissueSolver(given, features, "opencl"),
        is_verlet_(scene().method == Method::velocity_verlet),
        is_implicit_(scene().method == Method::implicit_euler),
        constants_(scene(), lattice(), substep_s()),
        local_size_(static_cast<std::size_t>(options.work_group_size)),
        device_(std::move(device)) {
    open();
    build();
    allocate();
    bind();
    warm_up();
  }

 protected:
  void substep(const ToolStates& before, const ToolStates& after) override {
    if (is_implicit_) {
      solve(after);
      put_grabs(after);
    } else if (is_verlet_) {
      enqueue(kernels().drift, lattice().span);
      put_grabs(after);
      accelerate(after);
    } else {
      set_tools(kernels().advance, before);
      enqueue(kernels().advance, lattice().span);
      current_ = 1 - current_;
      put_grabs(after);
    }
  }

  void set_substep(double substep_s) override {
    constants_.set_substep(scene(), substep_s);
    bind_substep();
    if (is_implicit_) set_system(substep_s);
  }

  void read_tools(const ToolStates& now, ToolReadings& readings) override {
    if (result_.empty()) {
      check_cl(clFinish(queue_.get()), "clFinish");
      return;
    }
    if (grabbed_count_ > 0) enqueue(kernels().grab_force, padded(grabbed_count_));
    if (coupled_count_ > 0) {
      set_tools(kernels().coupling_force, now);
      enqueue(kernels().coupling_force, padded(coupled_count_));
    }
    for (std::size_t tool = 0; tool < scene().tools.size(); ++tool) {
      if (!is_probe(tool)) continue;
      set(kernels().probe[tool], kernels().probe[tool].tools_at, float4(now[tool].offset_m));
      enqueue(kernels().probe[tool], lattice().span);
      enqueue(probe_sums_[tool], probe_size());
    }
    if (!watched().empty()) enqueue(kernels().displacements, padded(watched().size()));
    read(result_buffer_, result_.size() * sizeof(float), result_.data());
    take_result(readings);
  }

  std::uint64_t digest() override {
    enqueue(kernels().cell_digest, lattice().span);
    enqueue(chunk_digest_, chunks());
    read(chunk_sums_, digest_sums_.size() * sizeof(std::uint64_t), digest_sums_.data());
    std::uint64_t digest = kDigestStart;
    for (const std::uint64_t sum : digest_sums_) digest = mix(digest, sum);
    return digest;
  }

  Energy energy(const ToolStates& now) override {
    set_tools(kernels().cell_energy, now);
    enqueue(kernels().cell_energy, lattice().span);
    Energy energy;
    energy.stored_J = add_energies(chunk_energy_, energy_sums_);
    if (features().gravity) energy.gravity_J = add_energies(chunk_gravity_energy_, gravity_energy_sums_);
    return energy;
  }

  void to_rest() override {
    const float zero = 0;
    for (const ClField* field : {&displacement_[0], &displacement_[1], &velocity_[0], &velocity_[1], &acceleration_, &x_, &z_, &p_}) {
      for (const ClBuffer* component : {&field->x, &field->y, &field->z}) {
        if (!component->get()) continue;
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
      if (!to.get()) return;
      for (std::size_t n = 0; n < from.size(); ++n)
        cells[lattice().cell(static_cast<std::int64_t>(n))] = static_cast<float>(from[n][axis]);
      check_cl(clEnqueueWriteBuffer(queue_.get(), to.get(), CL_TRUE, 0, cells.size() * sizeof(float), cells.data(), 0, nullptr,
                                    nullptr),
               "clEnqueueWriteBuffer");
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (const ClField& field : displacement_) put(field.axis(axis), state.displacement_m, axis);
      for (const ClField& field : velocity_) put(field.axis(axis), state.velocity_m_per_s, axis);
    }
  }

  void start() override {
    if (!is_verlet_) return;
    accelerate({});
    for (int axis = 0; axis < 3; ++axis) {  // which accelerate() took half a step further
      check_cl(clEnqueueCopyBuffer(queue_.get(), velocity_[1].axis(axis).get(), velocity_[0].axis(axis).get(), 0, 0,
                                   lattice().cells * sizeof(float), 0, nullptr, nullptr),
               "clEnqueueCopyBuffer");
    }
  }

  void read_state(ParticleState& state) override {
    std::vector<float> cells(lattice().cells);
    const auto get = [&](const ClBuffer& from, std::vector<glm::dvec3>& to, int axis) {
      read(from, cells.size() * sizeof(float), cells.data());
      for (std::size_t n = 0; n < to.size(); ++n) to[n][axis] = cells[lattice().cell(static_cast<std::int64_t>(n))];
    };
    for (int axis = 0; axis < 3; ++axis) {
      get(displacement(current_).axis(axis), state.displacement_m, axis);
      get(velocity(current_).axis(axis), state.velocity_m_per_s, axis);
    }
  }

 private:
  /// Of one direction of the ping-pong, which velocity Verlet does without.
  struct Kernels {
    BoundKernel advance, drift, accelerate, grab, grab_force, coupling_force, displacements, cell_digest, cell_energy;
    std::array<BoundKernel, kMaxTools> probe;
  };

  Kernels& kernels() { return kernels_[current_]; }
  std::size_t chunks() const { return lattice().span / kChunk; }
  std::size_t padded(std::size_t count) const { return (count + local_size_ - 1) / local_size_ * local_size_; }
  bool is_probe(std::size_t tool) const { return scene().tools[tool].kind == CouplingKind::probe; }

  /// One direction only: no ping-pong.
  bool in_place() const { return is_verlet_ || is_implicit_; }
  const ClField& displacement(std::size_t direction) const { return displacement_[in_place() ? 0 : direction]; }
  const ClField& velocity(std::size_t direction) const {
    return velocity_[!in_place() && features().axial_damping ? direction : 0];
  }
  /// The one that forces are evaluated with: half a substep behind the displacement in velocity Verlet too.
  const ClField& force_velocity(std::size_t direction) const { return is_verlet_ ? velocity_[1] : velocity(direction); }

  void accelerate(const ToolStates& tools) {
    set_tools(kernels().accelerate, tools);
    enqueue(kernels().accelerate, lattice().span);
  }

  void put_grabs(const ToolStates& tools) {
    if (grabbed_count_ == 0) return;
    for (std::size_t tool = 0; tool < scene().tools.size(); ++tool) {
      const cl_uint at = kernels().grab.tools_at + 2 * static_cast<cl_uint>(tool);
      set(kernels().grab, at, float4(tools[tool].offset_m));
      set(kernels().grab, at + 1, float4(tools[tool].velocity_m_per_s));
    }
    enqueue(kernels().grab, padded(grabbed_count_));
  }

  /// The result holds the grabbed particles' forces, then the coupled ones', each probe's sums and the watched cells.
  void take_result(ToolReadings& readings) const {
    std::size_t n = 0, grabbed = 0, coupled = 3 * grabbed_count_;
    for (std::size_t tool = 0; tool < scene().tools.size(); ++tool) {
      std::size_t& from = features().grab[tool] ? grabbed : coupled;
      for (std::size_t held = 0; held < lattice().held[tool].size(); ++held, from += 3)
        readings.held_N[n++] = {result_[from], result_[from + 1], result_[from + 2]};
      if (is_probe(tool))
        readings.probes[tool] =
            add_partials(std::span(result_).subspan(probe_at(tool), probe_size()), features().local_model);
    }
    for (std::size_t w = 0; w < watched().size(); ++w) {
      const std::size_t from = watched_at() + 3 * w;
      readings.displacement_m[w] = {result_[from], result_[from + 1], result_[from + 2]};
    }
  }
  std::size_t watched_at() const { return result_.size() - 3 * watched().size(); }
  std::size_t probe_size() const { return chunks() * features().probe_values(); }
  std::size_t probe_at(std::size_t tool) const {
    return 3 * (grabbed_count_ + coupled_count_) + (tool == 1 && is_probe(0) ? probe_size() : 0);
  }

  double add_energies(const BoundKernel& chunk_sums, const ClBuffer& buffer) {
    enqueue(chunk_sums, chunks());
    read(buffer, energy_parts_.size() * sizeof(float), energy_parts_.data());
    double total = 0;
    for (const float sum : energy_parts_) total += sum;
    return total;
  }

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

  std::string source() const {
    std::string source = kSpringsSource;
    source += is_implicit_ ? kImplicitSource : is_verlet_ ? kVerletSource : kAdvanceSource;
    if (features().grab[0] || features().grab[1]) source += std::string(kGrabSource) + kGrabForceSource;
    if (features().spring[0] || features().spring[1]) source += kCouplingForceSource;
    if (features().probes()) source += kProbeSource;
    if (!watched().empty()) source += kDisplacementsSource;
    if (features().digest) source += kDigestSource;
    if (features().energy) source += kEnergySource;
    return source;
  }

  void build() {
    const std::string source = this->source();
    const char* text = source.c_str();
    cl_int code = CL_SUCCESS;
    program_ = ClProgram(clCreateProgramWithSource(context_.get(), 1, &text, nullptr, &code));
    check_cl(code, "clCreateProgramWithSource");
    std::string options = build_options(constants_, lattice(), features(), device_.device);
    if (is_implicit_) options += implicit_options(constants_, features());
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
  template <class Value>
  ClBuffer buffer_of(const std::vector<Value>& content) {
    return buffer(content.size() * sizeof(Value), content.data());
  }
  ClField field() {
    const std::size_t bytes = lattice().cells * sizeof(float);
    return {buffer(bytes), buffer(bytes), buffer(bytes)};
  }

  void allocate() {
    displacement_[0] = field();
    if (!in_place()) displacement_[1] = field();
    velocity_[0] = field();
    if (is_verlet_ || (features().axial_damping && !is_implicit_)) velocity_[1] = field();
    if (is_verlet_) acceleration_ = field();
    active_ = buffer_of(std::vector<float>(lattice().active.begin(), lattice().active.end()));
    mobile_ = buffer_of(std::vector<float>(lattice().mobile.begin(), lattice().mobile.end()));
    if (features().regions) {
      const MaterialArrays<float> materials(scene(), lattice());
      stiffness_ = buffer_of(materials.stiffness);
      inverse_mass_ = buffer_of(materials.inverse_mass);
      if (features().energy || is_implicit_) mass_ = buffer_of(materials.mass);
    }
    if (is_implicit_) allocate_solve();
    allocate_tools();
    if (features().digest) {
      cell_digests_ = buffer(lattice().span * sizeof(cl_ulong));
      digest_sums_.resize(chunks());
      chunk_sums_ = buffer(chunks() * sizeof(cl_ulong));
    }
    if (!features().energy) return;
    energy_parts_.resize(chunks());
    cell_energies_ = buffer(lattice().span * sizeof(float));
    energy_sums_ = buffer(chunks() * sizeof(float));
    if (!features().gravity) return;
    gravity_energies_ = buffer(lattice().span * sizeof(float));
    gravity_energy_sums_ = buffer(chunks() * sizeof(float));
  }

  void allocate_tools() {
    std::vector<cl_uint> grabbed, coupled;
    std::size_t probes = 0;
    for (std::size_t tool = 0; tool < scene().tools.size(); ++tool) {
      const auto& held = lattice().held[tool];
      std::vector<cl_uint>& cells = features().grab[tool] ? grabbed : coupled;
      cells.insert(cells.end(), held.begin(), held.end());
      probes += is_probe(tool);
    }
    grabbed_count_ = grabbed.size();
    coupled_count_ = coupled.size();
    if (grabbed_count_ > 0) grabbed_ = buffer_of(grabbed);
    if (coupled_count_ > 0) coupled_ = buffer_of(coupled);
    for (std::size_t tool = 0; tool < kMaxTools; ++tool)
      if (features().spring[tool]) held_[tool] = buffer_of(held_cells<float>(scene(), lattice(), tool));
    if (features().probes()) {
      const auto rest_m = [&](int component) { return buffer_of(rest_positions<float>(scene(), lattice(), component)); };
      rest_m_ = {rest_m(0), rest_m(1), rest_m(2)};
      probe_cells_ = buffer(lattice().span * features().probe_values() * sizeof(float));
    }
    result_.resize(3 * (grabbed_count_ + coupled_count_) + probes * probe_size() + 3 * watched().size());
    if (!watched().empty()) watched_cells_ = buffer_of(watched());
    if (!result_.empty()) result_buffer_ = buffer(result_.size() * sizeof(float));
  }

  /// Arguments in the order of the kernels' parameters (kernels/*.cl).
  void bind() {
    for (std::size_t from = 0; from < (in_place() ? 1 : 2); ++from) {
      Kernels& kernels = kernels_[from];
      if (is_implicit_) {
        bind_solve();
      } else if (is_verlet_) {
        bind_verlet(kernels);
      } else {
        bind_advance(kernels.advance, from);
      }
      bind_tools(kernels, from);
      const ClField &u = displacement(from), &v = velocity(from);
      if (features().digest) {
        create(kernels.cell_digest, "cell_digest");
        add(kernels.cell_digest, u, v, cell_digests_);
      }
      if (features().energy) bind_energy(kernels.cell_energy, u, v);
    }
    if (features().variable_step) bind_substep();
    for (std::size_t tool = 0; tool < scene().tools.size(); ++tool) {
      if (!is_probe(tool)) continue;
      create(probe_sums_[tool], "probe_sums");
      add(probe_sums_[tool], probe_cells_, static_cast<cl_uint>(probe_at(tool)), result_buffer_);
    }
    if (features().digest) {
      create(chunk_digest_, "chunk_digest");
      add(chunk_digest_, cell_digests_, chunk_sums_);
    }
    if (!features().energy) return;
    create(chunk_energy_, "chunk_energy");
    add(chunk_energy_, cell_energies_, energy_sums_);
    if (!features().gravity) return;
    create(chunk_gravity_energy_, "chunk_energy");
    add(chunk_gravity_energy_, gravity_energies_, gravity_energy_sums_);
  }

  void bind_advance(BoundKernel& advance, std::size_t from) {
    create(advance, "advance");
    add(advance, displacement(from), displacement(1 - from), velocity(from));
    if (features().axial_damping) add(advance, velocity(1 - from));
    add(advance, active_, mobile_);
    add_materials(advance);
    add_tools(advance);
    advance.step_at = advance.arguments;
  }

  void bind_verlet(Kernels& kernels) {
    create(kernels.drift, "drift");
    add(kernels.drift, velocity_[0], acceleration_, velocity_[1], displacement_[0], mobile_);
    kernels.drift.step_at = kernels.drift.arguments;
    create(kernels.accelerate, "accelerate");
    add(kernels.accelerate, displacement_[0], velocity_[1], velocity_[0], acceleration_, active_, mobile_);
    add_materials(kernels.accelerate);
    add_tools(kernels.accelerate);
    kernels.accelerate.step_at = kernels.accelerate.arguments;
  }

  void allocate_solve() {
    for (ClField* each : {&x_, &z_, &r_, &p_, &q_}) *each = field();
    scale_.resize(lattice().span);
    scale_buffer_ = buffer(lattice().span * sizeof(float));
    products_ = buffer(lattice().span * sizeof(float));
    product_sums_ = buffer(chunks() * sizeof(float));
    partial_sums_.resize(chunks());
  }

  void bind_solve() {
    const ClField &u = displacement_[0], &v = velocity_[0];
    const ClBuffer& mass = features().regions ? mass_ : mobile_;
    const cl_float4 none{};
    const float h = 0;  // set in every substep
    if (features().grab[0] || features().grab[1]) {
      create(aim_grabs_, "aim_grabs");
      add(aim_grabs_, grabbed_, static_cast<cl_uint>(grabbed_count_),
          static_cast<cl_uint>(features().grab[0] ? lattice().held[0].size() : 0), u, v);
      bind_length(aim_grabs_, h);
      aim_grabs_.tools_at = aim_grabs_.arguments;
      add(aim_grabs_, none, none, none, none);
    }
    create(begin_solve_, "begin_solve");
    add(begin_solve_, u, v, mobile_, x_, z_);
    bind_length(begin_solve_, h);
    create(residual_, "residual");
    add(residual_, z_, x_, active_, mobile_);
    add_materials(residual_);
    add_tools(residual_);
    add(residual_, v, mass, scale_buffer_, r_, p_, products_);
    bind_length(residual_, h);
    create(apply_system_, "apply_system");
    add(apply_system_, z_, active_, mobile_);
    if (features().regions) add(apply_system_, stiffness_);
    add_tools(apply_system_);
    add(apply_system_, p_, mass, q_, products_);
    apply_system_.step_at = apply_system_.arguments;
    create(advance_solution_, "advance_solution");
    add(advance_solution_, p_, q_, scale_buffer_, x_, r_, products_);
    create(advance_direction_, "advance_direction");
    add(advance_direction_, r_, scale_buffer_, p_);
    create(finish_solve_, "finish_solve");
    add(finish_solve_, x_, u, v);
    bind_length(finish_solve_, h);
    create(chunk_sum_, "chunk_sum");
    add(chunk_sum_, products_, product_sums_);
    set_system(substep_s());
  }
  void bind_length(BoundKernel& kernel, float h) {
    kernel.step_at = kernel.arguments;
    add(kernel, h);
  }

  /// What depends on the length of the substep.
  void set_system(double substep_s) {
    const SystemConstants<float> system(scene(), substep_s);
    const std::vector<float> active(lattice().active.begin(), lattice().active.end());
    const std::vector<float> mobile(lattice().mobile.begin(), lattice().mobile.end());
    const MaterialArrays<float> materials(scene(), lattice());
    std::array<std::vector<float>, kMaxTools> held;
    const std::size_t first = lattice().first;
    CellArrays<float> arrays;
    arrays.active = active.data() + first;
    arrays.mobile = arrays.inverse_mass = arrays.mass = mobile.data() + first;
    arrays.offset = lattice().offset;
    if (features().regions) {
      arrays.stiffness = materials.stiffness.data() + first;
      arrays.inverse_mass = materials.inverse_mass.data() + first;
      arrays.mass = materials.mass.data() + first;
    }
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      if (!features().spring[tool]) continue;
      held[tool] = held_cells<float>(scene(), lattice(), tool);
      arrays.held[tool] = held[tool].data() + first;
    }
    const MethodCells<float> cells{scene(), lattice(), features(), constants_, arrays};
    fill_inverse_diagonal(cells, system, substep_s, scale_);
    check_cl(clEnqueueWriteBuffer(queue_.get(), scale_buffer_.get(), CL_TRUE, 0, scale_.size() * sizeof(float), scale_.data(),
                                  0, nullptr, nullptr),
             "clEnqueueWriteBuffer");
    const ToolTerms<float> terms(cells, {}, substep_s);
    set(apply_system_, apply_system_.step_at, cl_float4{{system.inertia, system.stiffness, system.axial, 0}});
    set(apply_system_, apply_system_.step_at + 1, cl_float4{{terms.damping[0], terms.damping[1], 0, 0}});
    const auto h = static_cast<float>(substep_s);
    for (const BoundKernel* kernel : {&aim_grabs_, &begin_solve_, &residual_, &finish_solve_})
      if (kernel->kernel.get()) set(*kernel, kernel->step_at, h);
  }

  /// One substep of implicit Euler, as in cpu/methods/implicit.cpp.
  void solve(const ToolStates& after) {
    if (aim_grabs_.kernel.get()) {
      for (std::size_t tool = 0; tool < kMaxTools; ++tool)
        set(aim_grabs_, aim_grabs_.tools_at + 2 * static_cast<cl_uint>(tool), float4(after[tool].offset_m));
      enqueue(aim_grabs_, padded(grabbed_count_));
    }
    enqueue(begin_solve_, lattice().span);
    set_tools(residual_, after);
    set_tools(apply_system_, after);
    enqueue(residual_, lattice().span);
    float residual = sum_products();
    const float floor = residual_floor(residual);
    for (int n = 0; n < iterations_of(scene()) && !(residual <= floor); ++n) residual = iterate(residual);
    enqueue(finish_solve_, lattice().span);
  }

  float iterate(float residual) {
    enqueue(apply_system_, lattice().span);
    const float curvature = sum_products();
    set(advance_solution_, advance_solution_.arguments, curvature > 0 ? residual / curvature : 0.0f);
    enqueue(advance_solution_, lattice().span);
    const float left = sum_products();
    set(advance_direction_, advance_direction_.arguments, left / residual);
    enqueue(advance_direction_, lattice().span);
    return left;
  }

  float sum_products() {
    enqueue(chunk_sum_, chunks());
    read(product_sums_, partial_sums_.size() * sizeof(float), partial_sums_.data());
    float total = 0;
    for (const float sum : partial_sums_) total += sum;
    return total;
  }

  void bind_tools(Kernels& kernels, std::size_t from) {
    const ClField &u = displacement(from), &v = force_velocity(from);
    const cl_float4 none{};
    if (grabbed_count_ > 0) {
      const auto count = static_cast<cl_uint>(grabbed_count_);
      create(kernels.grab, "grab");
      add(kernels.grab, grabbed_, count, static_cast<cl_uint>(features().grab[0] ? lattice().held[0].size() : 0));
      kernels.grab.tools_at = kernels.grab.arguments;
      add(kernels.grab, none, none, none, none, u, v);
      create(kernels.grab_force, "grab_force");
      add(kernels.grab_force, grabbed_, count, u);
      if (features().axial_damping) add(kernels.grab_force, v);
      add(kernels.grab_force, active_);
      if (features().regions) add(kernels.grab_force, stiffness_);
      add(kernels.grab_force, cl_uint{0}, result_buffer_);
    }
    if (coupled_count_ > 0) {
      create(kernels.coupling_force, "coupling_force");
      add(kernels.coupling_force, coupled_, static_cast<cl_uint>(coupled_count_), u, v);
      add_tools(kernels.coupling_force);
      add(kernels.coupling_force, static_cast<cl_uint>(3 * grabbed_count_), result_buffer_);
    }
    if (!watched().empty()) {
      create(kernels.displacements, "displacements");
      add(kernels.displacements, watched_cells_, static_cast<cl_uint>(watched().size()), u,
          static_cast<cl_uint>(watched_at()), result_buffer_);
    }
    for (std::size_t tool = 0; tool < scene().tools.size(); ++tool) {
      if (!is_probe(tool)) continue;
      const ToolConstants<float>& constants = constants_.tools[tool];
      const auto& [x, y, z] = constants.center_m;
      create(kernels.probe[tool], "probe_cells");
      add(kernels.probe[tool], u, rest_m_, mobile_, constants.stiffness, constants.radius_m, cl_float4{{x, y, z, 0}},
          probe_cells_);
      kernels.probe[tool].tools_at = kernels.probe[tool].arguments;
      add(kernels.probe[tool], none);
    }
  }

  void bind_energy(BoundKernel& energy, const ClField& u, const ClField& v) {
    create(energy, "cell_energy");
    add(energy, u, v, active_, mobile_);
    if (features().regions) add(energy, stiffness_, mass_);
    add_tools(energy);
    add(energy, cell_energies_);
    if (features().gravity) add(energy, gravity_energies_);
  }

  void add_materials(BoundKernel& kernel) {
    if (features().regions) add(kernel, stiffness_, inverse_mass_);
  }
  void add_tools(BoundKernel& kernel) {
    for (std::size_t tool = 0; tool < kMaxTools; ++tool)
      if (features().spring[tool]) add(kernel, held_[tool]);
    if (features().probes()) add(kernel, rest_m_);
    if (!features().tool_forces()) return;
    const cl_float4 none{};
    kernel.tools_at = kernel.arguments;
    add(kernel, none, none, none, none);
  }

  static cl_float4 float4(const std::array<double, 3>& v) {
    return {{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0}};
  }
  void set_tools(BoundKernel& kernel, const ToolStates& tools) {
    if (!features().tool_forces()) return;
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      const cl_uint at = kernel.tools_at + 2 * static_cast<cl_uint>(tool);
      set(kernel, at, float4(tools[tool].offset_m));
      set(kernel, at + 1, float4(tools[tool].velocity_m_per_s));
    }
  }

  /// The substep's length is an argument only of kernels built for one that varies (kernels/springs.cl).
  void bind_substep() {
    for (Kernels& kernels : kernels_) {
      for (BoundKernel* kernel : {&kernels.advance, &kernels.drift, &kernels.accelerate}) {
        if (!kernel->kernel.get()) continue;
        const auto& [x, y, z] = constants_.gravity;
        set(*kernel, kernel->step_at, constants_.step_s);
        set(*kernel, kernel->step_at + 1, constants_.half_step_s);
        set(*kernel, kernel->step_at + 2, constants_.acceleration);
        set(*kernel, kernel->step_at + 3, constants_.decay);
        set(*kernel, kernel->step_at + 4, cl_float4{{x, y, z, 0}});
      }
    }
  }

  /// PoCL compiles a kernel at its first launch (up to 250 ms), so every kernel runs before t = 0.
  void warm_up() {
    to_rest();
    ToolReadings ignored = empty_readings();
    for (int direction = 0; direction < 2; ++direction) {
      substep({}, {});
      if (is_implicit_) iterate(1);  // which the state of rest needs none of
      read_tools({}, ignored);
      if (features().digest) digest();
      if (features().energy) energy({});
    }
    to_start();
  }

  void create(BoundKernel& kernel, const char* name) {
    cl_int code = CL_SUCCESS;
    kernel.kernel = ClKernel(clCreateKernel(program_.get(), name, &code));
    check_cl(code, fmt::format("clCreateKernel({})", name));
  }
  template <class... Arguments>
  void add(BoundKernel& kernel, const Arguments&... arguments) {
    (add_one(kernel, arguments), ...);
  }
  void add_one(BoundKernel& kernel, const ClField& field) { add(kernel, field.x, field.y, field.z); }
  void add_one(BoundKernel& kernel, const ClBuffer& buffer) { add_one(kernel, buffer.get()); }
  template <class Value>
  void add_one(BoundKernel& kernel, const Value& value) {
    set(kernel, kernel.arguments++, value);
  }
  template <class Value>
  void set(const BoundKernel& kernel, cl_uint index, const Value& value) {
    check_cl(clSetKernelArg(kernel.kernel.get(), index, sizeof value, &value), "clSetKernelArg");
  }
  /// `count` is a multiple of the work-group size, except for the few chunk sums.
  void enqueue(const BoundKernel& kernel, std::size_t count) {
    const std::size_t* local = count % local_size_ == 0 ? &local_size_ : nullptr;
    check_cl(clEnqueueNDRangeKernel(queue_.get(), kernel.kernel.get(), 1, nullptr, &count, local, 0, nullptr, nullptr),
             "clEnqueueNDRangeKernel");
  }
  void read(const ClBuffer& from, std::size_t bytes, void* to) {
    check_cl(clEnqueueReadBuffer(queue_.get(), from.get(), CL_TRUE, 0, bytes, to, 0, nullptr, nullptr),
             "clEnqueueReadBuffer");
  }

  bool is_verlet_, is_implicit_;
  TissueConstants<float> constants_;
  std::size_t local_size_;
  ClDevice device_;
  ClContext context_;
  ClQueue queue_;
  ClProgram program_;
  std::array<ClField, 2> displacement_;  // from rest, m; current_ is the newest
  std::array<ClField, 2> velocity_;      // as displacement_, or the whole step's and the half step's of velocity Verlet
  ClField acceleration_, rest_m_;
  ClBuffer active_, mobile_, stiffness_, inverse_mass_, mass_, grabbed_, coupled_, watched_cells_, result_buffer_;
  std::array<ClBuffer, kMaxTools> held_;
  ClBuffer cell_digests_, chunk_sums_, cell_energies_, energy_sums_, gravity_energies_, gravity_energy_sums_;
  std::array<Kernels, 2> kernels_;  // [c] reads displacement_[c]
  BoundKernel chunk_digest_, chunk_energy_, chunk_gravity_energy_;
  std::array<BoundKernel, kMaxTools> probe_sums_;
  ClBuffer probe_cells_;
  ClField x_, z_, r_, p_, q_;  // implicit Euler (kernels/implicit.cl)
  ClBuffer scale_buffer_, products_, product_sums_;
  std::vector<float> scale_, partial_sums_;
  BoundKernel aim_grabs_, begin_solve_, residual_, apply_system_, advance_solution_, advance_direction_, finish_solve_,
      chunk_sum_;
  std::size_t grabbed_count_ = 0, coupled_count_ = 0;
  std::vector<float> result_, energy_parts_;
  std::vector<std::uint64_t> digest_sums_;
  std::size_t current_ = 0;
};

}  // namespace

/// PoCL 3.1 corrupts itself when two threads look for devices, or build and first launch the same program, at once (seen: no
/// device, CL_INVALID_KERNEL_NAME, crashes), so the solvers of a process are made one after the other.
std::unique_ptr<Solver> make_opencl_tissue(const Scene& scene, const SceneFeatures& features, const SolverOptions& options) {
  check_tissue(std::get<TissueScene>(scene.body), scene.tool_count);
  check_method(std::get<TissueScene>(scene.body).method, "opencl");
  if (options.work_group_size < 1 || kChunk % static_cast<std::size_t>(options.work_group_size) != 0) {
    throw SolverError(SolverFault::bad_scene, fmt::format("a work-group size of {}", options.work_group_size),
                      fmt::format("a divisor of {}", kChunk));
  }
  static std::mutex making;
  const std::lock_guard one_at_a_time(making);
  ClDevice device = choose_device(options.opencl_platform, options.opencl_device);
  check_memory(scene, features, device);
  return std::make_unique<OpenClTissue>(scene, features, options, std::move(device));
}

}  // namespace evenstep::internal
