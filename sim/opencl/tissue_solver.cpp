// The real solver: the kernels of opencl/kernels, bit for bit equal to cpu/tissue_solver.cpp in float.
#include "src/tissue/tissue_solver.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <vector>

#include "evenstep/time/digest.h"
#include "opencl/build_options.h"
#include "opencl/cell_buffers.h"
#include "opencl/cl_commands.h"
#include "opencl/implicit_solve.h"
#include "opencl/opencl_solver.h"
#include "opencl/tool_kernels.h"
#include "opencl_kernels.h"

namespace evenstep::internal {
namespace {

/// Called before anything is allocated: some drivers grant more memory than they have, and fail at the first launch.
void check_memory(const Scene& scene, const SceneFeatures& features, const ClDevice& device) {
  cl_ulong there = 0, largest = 0;
  check_cl(cl().clGetDeviceInfo(device.device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof there, &there, nullptr), "clGetDeviceInfo");
  check_cl(cl().clGetDeviceInfo(device.device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof largest, &largest, nullptr),
           "clGetDeviceInfo");
  const auto& tissue = std::get<TissueScene>(scene.body);
  const double digest_bytes = features.digest ? sizeof(cl_ulong) : 0;
  const double probe_bytes = features.probes() ? static_cast<double>(sizeof(float) * features.probe_values()) : 0;
  const double one = cells_of(tissue) * std::max({double{sizeof(float)}, digest_bytes, probe_bytes});
  const int arrays = scalar_arrays(features, tissue.method) + (needs_holding(features, tissue.method) ? 1 : 0);
  const double needed = cells_of(tissue) * (double{sizeof(float)} * arrays + digest_bytes + probe_bytes);
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
        commands_(std::move(device), static_cast<std::size_t>(options.work_group_size), options.log_commands),
        cells_(scene(), lattice(), this->features(), substep_s(), commands_),
        tools_(cells_, watched(), commands_) {
    set_device(commands_.device().name);
    build();
    allocate();
    bind();
    warm_up();
  }
  CommandLog* command_log() override { return commands_.log(); }

 protected:
  void substep(const ToolStates& before, const ToolStates& after) override {
    if (solve_) {
      solve_->substep(after);
    } else if (is_verlet_) {
      commands_.enqueue(kernels().drift, lattice().span);
    } else {
      BoundKernel& advance = kernels().advance;  // it puts the grabbed particles, too
      cells_.set_tools(advance, before);
      if (features().grabs()) set_tool_states(advance, advance.grabs_at, after);
      commands_.enqueue(advance, lattice().span);
      current_ = 1 - current_;
      return;
    }
    tools_.put_grabs(current_, after);
    if (is_verlet_) accelerate(after);
  }

  void set_substep(double substep_s) override {
    cells_.constants.set_substep(scene(), substep_s);
    bind_substep();
    if (solve_) solve_->set_substep(substep_s);
  }

  void read_tools(const ToolStates& now, ToolReadings& readings) override { tools_.read(current_, now, readings); }

  ProbeSums read_probe(std::size_t tool, const ToolStates& now, double radius_m) override {
    return tools_.read_probe(current_, tool, now, static_cast<float>(radius_m));
  }

  std::uint64_t digest() override {
    commands_.enqueue(kernels().cell_digest, lattice().span);
    commands_.enqueue(chunk_digest_, cells_.chunks());
    commands_.read(chunk_sums_, digest_sums_);
    std::uint64_t digest = kDigestStart;
    for (const std::uint64_t sum : digest_sums_) digest = mix(digest, sum);
    return digest;
  }

  Energy energy(const ToolStates& now) override {
    cells_.set_tools(kernels().cell_energy, now);
    commands_.enqueue(kernels().cell_energy, lattice().span);
    Energy energy;
    energy.stored_J = add_energies(chunk_energy_, energy_sums_);
    if (features().gravity) energy.gravity_J = add_energies(chunk_gravity_energy_, gravity_energy_sums_);
    return energy;
  }

  void to_rest() override {
    for (const ClField* field : {&displacement_[0], &displacement_[1], &velocity_[0], &velocity_[1], &acceleration_}) {
      for (int axis = 0; axis < 3; ++axis)
        if (field->axis(axis).get()) commands_.zero(field->axis(axis), lattice().cells * sizeof(float));
    }
    if (solve_) solve_->to_rest();
    commands_.finish();
  }

  void put_state(const ParticleState& state) override {
    std::vector<float> cells(lattice().cells);
    const auto put = [&](const ClBuffer& to, const std::vector<glm::dvec3>& from, int axis) {
      if (!to.get()) return;
      for (std::size_t n = 0; n < from.size(); ++n)
        cells[lattice().cell(static_cast<std::int64_t>(n))] = static_cast<float>(from[n][axis]);
      commands_.write(cells, to);
    };
    for (int axis = 0; axis < 3; ++axis) {
      for (const ClField& field : displacement_) put(field.axis(axis), state.displacement_m, axis);
      for (const ClField& field : velocity_) put(field.axis(axis), state.velocity_m_per_s, axis);
    }
  }

  void start() override {
    if (!is_verlet_) return;
    accelerate({});
    for (int axis = 0; axis < 3; ++axis)  // undoes the half step that accelerate() took
      commands_.copy(velocity_[1].axis(axis), velocity_[0].axis(axis), lattice().cells * sizeof(float));
  }

  void read_state(ParticleState& state) override {
    std::vector<float> cells(lattice().cells);
    const auto get = [&](const ClBuffer& from, std::vector<glm::dvec3>& to, int axis) {
      commands_.read(from, cells);
      for (std::size_t n = 0; n < to.size(); ++n) to[n][axis] = cells[lattice().cell(static_cast<std::int64_t>(n))];
    };
    for (int axis = 0; axis < 3; ++axis) {
      get(displacement(current_).axis(axis), state.displacement_m, axis);
      get(velocity(current_).axis(axis), state.velocity_m_per_s, axis);
    }
  }

 private:
  /// The kernels of one direction of the ping-pong; velocity Verlet and implicit Euler have no ping-pong.
  struct Kernels {
    BoundKernel advance, drift, accelerate, cell_digest, cell_energy;
  };

  Kernels& kernels() { return kernels_[current_]; }

  /// One direction only: no ping-pong.
  bool in_place() const { return is_verlet_ || is_implicit_; }
  const ClField& displacement(std::size_t direction) const { return displacement_[in_place() ? 0 : direction]; }
  const ClField& velocity(std::size_t direction) const {
    return velocity_[!in_place() && features().axial_damping ? direction : 0];
  }
  /// The velocity that forces are evaluated with: half a substep behind the displacement in velocity Verlet too.
  const ClField& force_velocity(std::size_t direction) const { return is_verlet_ ? velocity_[1] : velocity(direction); }

  void accelerate(const ToolStates& tools) {
    cells_.set_tools(kernels().accelerate, tools);
    commands_.enqueue(kernels().accelerate, lattice().span);
  }

  double add_energies(const BoundKernel& chunk_sums, const ClBuffer& buffer) {
    commands_.enqueue(chunk_sums, cells_.chunks());
    commands_.read(buffer, energy_parts_);
    double total = 0;
    for (const float sum : energy_parts_) total += sum;
    return total;
  }

  std::string source() const {
    std::string source = std::string(kHeadSource) + kSpringsSource;
    source += is_implicit_ ? kImplicitSystemSource : is_verlet_ ? kVerletSource : kAdvanceSource;
    if (features().grabs()) source += kGrabForceSource;
    if (features().spring[0] || features().spring[1]) source += kCouplingForceSource;
    if (features().energy) source += kEnergySource;
    return source;
  }

  /// Two programs. The second is the same for every scene, so a driver that caches what it compiles has it already; of its
  /// kernels, only those that are launched are compiled.
  void build() {
    std::string options = build_options(cells_.constants, lattice(), features(), commands_.device().device);
    if (is_implicit_) options += implicit_options(cells_.constants, features());
    commands_.build(source(), options);
    commands_.build(
        std::string(kHeadSource) + kSumsSource + kGrabSource + kProbeSource + kDisplacementsSource + kImplicitSource,
        common_options(commands_.device().device));
  }

  void allocate() {
    const auto field = [&] { return commands_.field(lattice().cells); };
    displacement_[0] = field();
    if (!in_place()) displacement_[1] = field();
    velocity_[0] = field();
    if (is_verlet_ || (features().axial_damping && !is_implicit_)) velocity_[1] = field();
    if (is_verlet_) acceleration_ = field();
    if (features().digest) {
      cell_digests_ = commands_.buffer(lattice().span * sizeof(cl_ulong));
      digest_sums_.resize(cells_.chunks());
      chunk_sums_ = commands_.buffer(cells_.chunks() * sizeof(cl_ulong));
    }
    if (!features().energy) return;
    energy_parts_.resize(cells_.chunks());
    cell_energies_ = commands_.buffer(lattice().span * sizeof(float));
    energy_sums_ = commands_.buffer(cells_.chunks() * sizeof(float));
    if (!features().gravity) return;
    gravity_energies_ = commands_.buffer(lattice().span * sizeof(float));
    gravity_energy_sums_ = commands_.buffer(cells_.chunks() * sizeof(float));
  }

  /// Arguments in the order of the kernels' parameters (kernels/*.cl).
  void bind() {
    if (is_implicit_) solve_.emplace(cells_, tools_, displacement_[0], velocity_[0], substep_s(), commands_);
    for (std::size_t from = 0; from < (in_place() ? 1 : 2); ++from) {
      Kernels& kernels = kernels_[from];
      if (is_verlet_) bind_verlet(kernels);
      if (!in_place()) bind_advance(kernels.advance, from);
      tools_.bind(from, displacement(from), force_velocity(from));
      const ClField &u = displacement(from), &v = velocity(from);
      if (features().digest) {
        kernels.cell_digest = commands_.kernel("cell_digest");
        kernels.cell_digest.add(u, v, cell_digests_, cl_ulong{lattice().first});
      }
      if (features().energy) bind_energy(kernels.cell_energy, u, v);
    }
    if (features().variable_step) bind_substep();
    if (features().digest) {
      chunk_digest_ = commands_.kernel("chunk_digest");
      chunk_digest_.add(cell_digests_, chunk_sums_);
    }
    if (!features().energy) return;
    chunk_energy_ = commands_.kernel("chunk_sum");
    chunk_energy_.add(cell_energies_, energy_sums_);
    if (!features().gravity) return;
    chunk_gravity_energy_ = commands_.kernel("chunk_sum");
    chunk_gravity_energy_.add(gravity_energies_, gravity_energy_sums_);
  }

  void bind_advance(BoundKernel& advance, std::size_t from) {
    advance = commands_.kernel("advance");
    advance.add(displacement(from), displacement(1 - from), velocity(from));
    if (features().axial_damping) advance.add(velocity(1 - from));
    advance.add(cells_.active, cells_.holding.get() ? cells_.holding : cells_.mobile);
    cells_.add_materials(advance);
    cells_.add_tools(advance);
    const cl_float4 none{};
    advance.grabs_at = advance.next();
    if (features().grabs()) advance.add(none, none, none, none);
    advance.step_at = advance.next();
  }

  void bind_verlet(Kernels& kernels) {
    kernels.drift = commands_.kernel("drift");
    kernels.drift.add(velocity_[0], acceleration_, velocity_[1], displacement_[0], cells_.mobile);
    kernels.drift.step_at = kernels.drift.next();
    kernels.accelerate = commands_.kernel("accelerate");
    kernels.accelerate.add(displacement_[0], velocity_[1], velocity_[0], acceleration_, cells_.active, cells_.mobile);
    cells_.add_materials(kernels.accelerate);
    cells_.add_tools(kernels.accelerate);
    kernels.accelerate.step_at = kernels.accelerate.next();
  }

  void bind_energy(BoundKernel& energy, const ClField& u, const ClField& v) {
    energy = commands_.kernel("cell_energy");
    energy.add(u, v, cells_.active, cells_.mobile);
    if (features().regions) energy.add(cells_.stiffness, cells_.mass);
    cells_.add_tools(energy);
    energy.add(cell_energies_);
    if (features().gravity) energy.add(gravity_energies_);
  }

  /// The substep's length is an argument only of kernels built for one that varies (kernels/springs.cl).
  void bind_substep() {
    const TissueConstants<float>& constants = cells_.constants;
    const auto& [x, y, z] = constants.gravity;
    for (Kernels& kernels : kernels_) {
      for (BoundKernel* kernel : {&kernels.advance, &kernels.drift, &kernels.accelerate}) {
        if (!*kernel) continue;
        kernel->set(kernel->step_at, constants.step_s);
        kernel->set(kernel->step_at + 1, constants.half_step_s);
        kernel->set(kernel->step_at + 2, constants.acceleration);
        kernel->set(kernel->step_at + 3, constants.decay);
        kernel->set(kernel->step_at + 4, cl_float4{{x, y, z, 0}});
      }
    }
  }

  /// PoCL compiles a kernel at its first launch (up to 250 ms), so every kernel runs before t = 0, in both directions.
  void warm_up() {
    to_rest();
    ToolReadings ignored = empty_readings();
    for (int direction = 0; direction < 2; ++direction) {
      substep({}, {});
      if (solve_) solve_->iterate(1);  // a scene at rest needs no iteration
      read_tools({}, ignored);
      if (features().digest) digest();
      if (features().energy) energy({});
    }
    to_start();
  }

  bool is_verlet_, is_implicit_;
  ClCommands commands_;
  CellBuffers cells_;
  ToolKernels tools_;
  std::array<ClField, 2> displacement_;  // from rest, m; current_ is the newest
  std::array<ClField, 2> velocity_;      // as displacement_; in velocity Verlet at the whole and at the half step
  ClField acceleration_;                 // Verlet
  std::optional<ImplicitSolve> solve_;
  ClBuffer cell_digests_, chunk_sums_, cell_energies_, energy_sums_, gravity_energies_, gravity_energy_sums_;
  std::array<Kernels, 2> kernels_;  // [c] reads displacement_[c]
  BoundKernel chunk_digest_, chunk_energy_, chunk_gravity_energy_;
  std::vector<float> energy_parts_;
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
  ClDevice device = choose_device(options);
  check_memory(scene, features, device);
  return std::make_unique<OpenClTissue>(scene, features, options, std::move(device));
}

}  // namespace evenstep::internal

bool evenstep::built_with_opencl() { return true; }

void evenstep::open_opencl(const SolverOptions& options) {
  const internal::ClCommands opened(internal::choose_device(options), static_cast<std::size_t>(options.work_group_size));
}

evenstep::OpenClDescription evenstep::describe_opencl(const SolverOptions& options) {
  return internal::describe(internal::choose_device(options));
}
