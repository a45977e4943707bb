// The reference: the arithmetic of opencl/kernels/*.cl for float (equal bit for bit) and double.
#include <fmt/format.h>
#include <unistd.h>

#include <utility>

#include "cpu/cell_loops.h"
#include "cpu/cpu_solvers.h"
#include "cpu/method.h"
#include "evenstep/time/digest.h"

namespace evenstep::internal {
namespace {

template <class Real>
class CpuTissue final : public TissueSolver {
 public:
  CpuTissue(const Scene& given, std::string name)
      : TissueSolver(given, std::move(name)),
        constants_(scene(), substep_s()),
        now_(lattice().cells),
        next_(lattice().cells),
        velocity_(lattice().cells),
        active_(lattice().active.begin(), lattice().active.end()),
        mobile_(lattice().mobile.begin(), lattice().mobile.end()),
        energies_(needs_energy() ? lattice().span : 0),
        method_(make_method<Real>({scene(), lattice(), constants_, first(active_), first(mobile_)}, substep_s())) {
    to_start();
  }

 protected:
  void substep(std::span<const GrabTarget> targets) override {
    if (method_) {
      method_->substep(write(now_), write(velocity_), targets);
      return;
    }
    advance<Real>(count(), read(now_), write(next_), write(velocity_), first(active_), first(mobile_), lattice().offset,
                  constants_);
    std::swap(now_, next_);
    for (std::size_t tool = 0; tool < targets.size(); ++tool) {
      const auto& [u, v] = targets[tool];
      for (const std::uint32_t i : lattice().held[tool]) {
        now_.put(i, u);
        velocity_.put(i, v);
      }
    }
  }

  void set_substep(double substep_s) override {
    constants_.set_substep(scene(), substep_s);
    if (method_) method_->set_substep(substep_s);
  }

  void grab_forces(std::span<std::array<double, 3>> forces_N) override {
    std::size_t n = 0;
    for (const auto& cells : lattice().held) {
      for (const std::uint32_t cell : cells) {
        const auto i = static_cast<std::ptrdiff_t>(cell) - static_cast<std::ptrdiff_t>(lattice().first);
        const Vector<Real> f = spring_force<Real>(read(now_), first(active_), lattice().offset, constants_, i);
        const Real k = constants_.stiffness_N_per_m;
        forces_N[n++] = {f.x * k, f.y * k, f.z * k};
      }
    }
  }

  std::uint64_t digest() override {
    std::uint64_t digest = kDigestStart;
    constexpr auto chunk = static_cast<std::ptrdiff_t>(kChunk);
    for (std::ptrdiff_t i = 0; i < count(); i += chunk)
      digest = mix(digest, chunk_digest<Real>(i, i + chunk, read(now_), read(velocity_)));
    return digest;
  }

  double energy() override {
    cell_energy<Real>(count(), read(now_), read(velocity_), first(active_), first(mobile_), lattice().offset, constants_,
                      energies_.data());
    double total = 0;
    for (std::size_t chunk = 0; chunk < energies_.size(); chunk += kChunk) {
      Real sum = 0;
      for (std::size_t i = chunk; i < chunk + kChunk; ++i) sum += energies_[i];
      total += sum;
    }
    return total;
  }

  void to_rest() override {
    for (Field* field : {&now_, &next_, &velocity_}) *field = Field(lattice().cells);
  }

  void put_state(const ParticleState& state) override {
    for (std::size_t n = 0; n < state.displacement_m.size(); ++n) {
      const std::size_t cell = lattice().cell(static_cast<std::int64_t>(n));
      const glm::dvec3 &u = state.displacement_m[n], &v = state.velocity_m_per_s[n];
      now_.put(cell, {u.x, u.y, u.z});
      next_.put(cell, {u.x, u.y, u.z});
      velocity_.put(cell, {v.x, v.y, v.z});
    }
  }

  void read_state(ParticleState& state) override {
    for (std::size_t n = 0; n < state.displacement_m.size(); ++n) {
      const std::size_t cell = lattice().cell(static_cast<std::int64_t>(n));
      state.displacement_m[n] = {now_.x[cell], now_.y[cell], now_.z[cell]};
      state.velocity_m_per_s[n] = {velocity_.x[cell], velocity_.y[cell], velocity_.z[cell]};
    }
  }

 private:
  /// Structure of arrays, one entry per cell.
  struct Field {
    explicit Field(std::size_t cells) : x(cells), y(cells), z(cells) {}
    void put(std::size_t i, const std::array<double, 3>& value) {
      x[i] = static_cast<Real>(value[0]);
      y[i] = static_cast<Real>(value[1]);
      z[i] = static_cast<Real>(value[2]);
    }
    std::vector<Real> x, y, z;
  };

  std::ptrdiff_t count() const { return static_cast<std::ptrdiff_t>(lattice().span); }
  const Real* first(const std::vector<Real>& cells) const { return cells.data() + lattice().first; }
  Real* first(std::vector<Real>& cells) const { return cells.data() + lattice().first; }
  Vectors<const Real> read(const Field& field) const { return {first(field.x), first(field.y), first(field.z)}; }
  Vectors<Real> write(Field& field) const { return {first(field.x), first(field.y), first(field.z)}; }

  TissueConstants<Real> constants_;
  Field now_, next_, velocity_;        // displacement from rest, m; m/s
  std::vector<Real> active_, mobile_;  // 1 or 0
  std::vector<Real> energies_;         // span, J
  std::unique_ptr<CellMethod<Real>> method_;  // null: advance()
};

/// Asked before anything is allocated: the system grants more than it has, and ends the program when it is used.
template <class Real>
std::unique_ptr<Solver> make_cpu_tissue(const Scene& scene, std::string name) {
  const auto& tissue = std::get<TissueScene>(scene.body);
  check_tissue(tissue, scene.tool_count);
  const double there = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  // 9 fields, 2 masks, the method's and perhaps the energies in Real, 2 masks in bytes.
  const double arrays = 11 + method_arrays(tissue.method) + (scene.needs_energy ? 1 : 0);
  const double needed = cells_of(tissue) * (sizeof(Real) * arrays + 2);
  if (needed > there) {
    throw SolverError(SolverFault::out_of_memory,
                      fmt::format("the scene needs {:.3g} bytes of memory, there are {:.3g}", needed, there),
                      "fewer particles");
  }
  return std::make_unique<CpuTissue<Real>>(scene, std::move(name));
}

}  // namespace

std::unique_ptr<Solver> make_cpu_tissue_float(const Scene& scene) { return make_cpu_tissue<float>(scene, "cpu"); }
std::unique_ptr<Solver> make_cpu_tissue_double(const Scene& scene) { return make_cpu_tissue<double>(scene, "cpu-double"); }

}  // namespace evenstep::internal
