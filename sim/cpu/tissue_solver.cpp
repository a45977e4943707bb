// The reference solver: the same arithmetic as opencl/kernels/*.cl, for float (equal bit for bit) and for double.
#include <fmt/format.h>
#include <unistd.h>

#include <type_traits>
#include <utility>

#include "cpu/cell_forces.h"
#include "cpu/cpu_solvers.h"
#include "cpu/host_cells.h"
#include "cpu/method.h"
#include "evenstep/time/digest.h"

namespace evenstep::internal {
namespace {

/// Calls `loop` with `a` and `b` as types, so that a separate loop is compiled for each combination.
template <class Loop>
void with(bool a, bool b, const Loop& loop) {
  if (a && b) return loop(std::true_type{}, std::true_type{});
  if (a) return loop(std::true_type{}, std::false_type{});
  if (b) return loop(std::false_type{}, std::true_type{});
  loop(std::false_type{}, std::false_type{});
}

template <class Real>
class CpuTissue final : public TissueSolver {
 public:
  CpuTissue(const Scene& given, const SceneFeatures& features, std::string name)
      : TissueSolver(given, features, std::move(name)),
        is_verlet_(scene().method == Method::velocity_verlet),
        constants_(scene(), lattice(), substep_s()),
        now_(lattice().cells),
        next_(is_verlet_ ? 0 : lattice().cells),
        velocity_(lattice().cells),
        before_(is_verlet_ || features.axial_damping ? lattice().cells : 0),
        acceleration_(is_verlet_ ? lattice().cells : 0),
        host_cells_(scene(), lattice(), features),
        cells_(host_cells_.arrays()),
        all_{scene(), lattice(), this->features(), constants_, cells_},
        method_(make_method<Real>(all_, substep_s())),
        energies_(features.energy ? lattice().span : 0),
        gravity_energies_(features.energy && features.gravity ? lattice().span : 0),
        probe_sums_(features.probes() ? lattice().span / kChunk * features.probe_values() : 0) {
    to_start();
  }

 protected:
  void substep(const ToolStates& before, const ToolStates& after) override {
    if (is_verlet_) return verlet(after);
    if (method_) return method_->substep(write(now_), write(velocity_), before, after);
    if (features().axial_damping) std::swap(velocity_, before_);
    const Field& old_velocity = features().axial_damping ? before_ : velocity_;
    with(features().damping, features().gravity, [&](auto damping, auto gravity) {
      for_chunks([&](std::ptrdiff_t begin, ChunkForces<Real>& forces) {
        chunk_forces<Real>(features(), begin, read(now_), read(old_velocity), cells_, constants_, before, forces);
        advance_chunk<BodyFeatures{damping, gravity}, Real>(begin, forces, cells_, constants_, read(now_), write(next_),
                                                            read(old_velocity), write(velocity_));
      });
    });
    std::swap(now_, next_);
    end_grabs(all_, after, write(now_), write(velocity_));
  }

  void set_substep(double substep_s) override {
    constants_.set_substep(scene(), substep_s);
    if (method_) method_->set_substep(substep_s);
  }

  void read_tools(const ToolStates& now, ToolReadings& readings) override {
    std::size_t n = 0;
    for (std::size_t tool = 0; tool < lattice().held.size(); ++tool) {
      for (const std::uint32_t cell : lattice().held[tool]) readings.held_N[n++] = force_on_hand(tool, cell, now);
      if (scene().tools[tool].kind == CouplingKind::probe)
        readings.probes[tool] = sum_probe(constants_.tools[tool], now[tool]);
    }
    for (std::size_t w = 0; w < watched().size(); ++w)
      readings.displacement_m[w] = {now_.x[watched()[w]], now_.y[watched()[w]], now_.z[watched()[w]]};
  }

  ProbeSums read_probe(std::size_t tool, const ToolStates& now, double radius_m) override {
    ToolConstants<Real> reaching = constants_.tools[tool];
    reaching.radius_m = static_cast<Real>(radius_m);
    return sum_probe(reaching, now[tool]);
  }

  std::uint64_t digest() override {
    std::uint64_t digest = kDigestStart;
    constexpr auto chunk = static_cast<std::ptrdiff_t>(kChunk);
    for (std::ptrdiff_t i = 0; i < count(); i += chunk)
      digest = mix(digest, chunk_digest<Real>(i, i + chunk, read(now_), read(velocity_)));
    return digest;
  }

  Energy energy(const ToolStates& now) override {
    const Vectors<const Real> u = read(now_);
    if (features().regions) {
      cell_energy<true, Real>(count(), u, read(velocity_), cells_, constants_, energies_.data());
    } else {
      cell_energy<false, Real>(count(), u, read(velocity_), cells_, constants_, energies_.data());
    }
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      if (features().spring[tool])
        add_coupling_energy<Real>(count(), u, cells_.held[tool], constants_.tools[tool], ToolVectors<Real>(now[tool]),
                                  energies_.data());
    }
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      if (features().probe[tool])
        add_probe_energy<Real>(count(), u, cells_, constants_.tools[tool], ToolVectors<Real>(now[tool]), energies_.data());
    }
    if (features().gravity) gravity_energy<Real>(count(), u, cells_, constants_, gravity_energies_.data());
    return {sum(energies_), sum(gravity_energies_)};
  }

  void to_rest() override {
    for (Field* field : {&now_, &next_, &velocity_, &before_, &acceleration_}) *field = Field(field->x.size());
  }

  void put_state(const ParticleState& state) override {
    for (std::size_t n = 0; n < state.displacement_m.size(); ++n) {
      const std::size_t cell = lattice().cell(static_cast<std::int64_t>(n));
      const glm::dvec3 &u = state.displacement_m[n], &v = state.velocity_m_per_s[n];
      for (Field* field : {&now_, &next_}) field->put(cell, {u.x, u.y, u.z});
      for (Field* field : {&velocity_, &before_}) field->put(cell, {v.x, v.y, v.z});
    }
  }

  void start() override {
    if (!is_verlet_) return;
    accelerate({});
    velocity_ = before_;  // accelerate() has advanced it by half a step
  }

  void read_state(ParticleState& state) override {
    for (std::size_t n = 0; n < state.displacement_m.size(); ++n) {
      const std::size_t cell = lattice().cell(static_cast<std::int64_t>(n));
      state.displacement_m[n] = {now_.x[cell], now_.y[cell], now_.z[cell]};
      state.velocity_m_per_s[n] = {velocity_.x[cell], velocity_.y[cell], velocity_.z[cell]};
    }
  }

 private:
  /// A vector field as a structure of arrays, one entry per cell; empty if the scene does not need it.
  struct Field {
    explicit Field(std::size_t cells) : x(cells), y(cells), z(cells) {}
    void put(std::size_t i, const std::array<double, 3>& value) {
      if (x.empty()) return;
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
  template <class Loop>
  void for_chunks(const Loop& loop) {
    for (std::ptrdiff_t begin = 0; begin < count(); begin += static_cast<std::ptrdiff_t>(kChunk)) loop(begin, forces_);
  }

  void verlet(const ToolStates& after) {
    const auto component = [&](std::vector<Real>& v, std::vector<Real>& a, std::vector<Real>& half, std::vector<Real>& u) {
      drift<Real>(count(), cells_.mobile, constants_, first(v), first(a), first(half), first(u));
    };
    component(velocity_.x, acceleration_.x, before_.x, now_.x);
    component(velocity_.y, acceleration_.y, before_.y, now_.y);
    component(velocity_.z, acceleration_.z, before_.z, now_.z);
    end_grabs(all_, after, write(now_), write(before_));
    accelerate(after);
  }

  /// Computes the acceleration from the displacement and from the half step's velocity in before_.
  void accelerate(const ToolStates& tools) {
    with(features().damping, features().gravity, [&](auto damping, auto gravity) {
      for_chunks([&](std::ptrdiff_t begin, ChunkForces<Real>& forces) {
        chunk_forces<Real>(features(), begin, read(now_), read(before_), cells_, constants_, tools, forces);
        accelerate_chunk<BodyFeatures{damping, gravity}, Real>(begin, forces, cells_, constants_, read(before_),
                                                               write(velocity_), write(acceleration_));
      });
    });
  }

  /// The velocity that forces are evaluated with.
  Vectors<const Real> force_velocity() const { return read(is_verlet_ ? before_ : velocity_); }

  std::array<double, 3> force_on_hand(std::size_t tool, std::uint32_t cell, const ToolStates& now) const {
    const auto i = static_cast<std::ptrdiff_t>(cell) - static_cast<std::ptrdiff_t>(lattice().first);
    const Real k = constants_.stiffness_N_per_m;
    if (features().grab[tool]) {
      const Vector<Real> f = spring_force<Real>({features().regions, features().axial_damping}, read(now_), force_velocity(),
                                                cells_, constants_, i);
      return {f.x * k, f.y * k, f.z * k};
    }
    Vector<Real> f;
    for (std::size_t t = 0; t < kMaxTools; ++t) {
      if (!features().spring[t]) continue;
      const Vector<Real> g =
          coupling_force<Real>(read(now_), force_velocity(), constants_.tools[t], ToolVectors<Real>(now[t]), i);
      const Real held = cells_.held[t][i];
      f = {f.x + held * g.x, f.y + held * g.y, f.z + held * g.z};
    }
    return {-(f.x * k), -(f.y * k), -(f.z * k)};
  }

  ProbeSums sum_probe(const ToolConstants<Real>& constants, const ToolState& now) {
    const std::size_t partials = lattice().span / kChunk;
    const auto run = [&](auto local_model) {
      probe_sums<local_model, Real>(static_cast<std::ptrdiff_t>(partials), read(now_), cells_, constants,
                                    ToolVectors<Real>(now), probe_sums_.data());
    };
    features().local_model ? run(std::true_type{}) : run(std::false_type{});
    return add_partials<Real>(probe_sums_, features().local_model);
  }

  static double sum(const std::vector<Real>& energies) {
    double total = 0;
    for (std::size_t chunk = 0; chunk < energies.size(); chunk += kChunk) {
      Real sum = 0;
      for (std::size_t i = chunk; i < chunk + kChunk; ++i) sum += energies[i];
      total += sum;
    }
    return total;
  }

  bool is_verlet_;
  TissueConstants<Real> constants_;
  Field now_, next_, velocity_;  // displacement from rest, m; m/s
  Field before_;                 // the velocity for forces: from before the substep, or half a substep before its end
  Field acceleration_;           // Verlet, m/s2
  HostCells<Real> host_cells_;
  const CellArrays<Real>& cells_;
  MethodCells<Real> all_;
  std::unique_ptr<CellMethod<Real>> method_;       // null for explicit methods that are a single loop
  std::vector<Real> energies_, gravity_energies_;  // span, J
  std::vector<Real> probe_sums_;
  ChunkForces<Real> forces_;
};

/// Memory is checked before anything is allocated: the system grants more than it has, and kills the program that uses it.
template <class Real>
std::unique_ptr<Solver> make_cpu_tissue(const Scene& scene, const SceneFeatures& features, std::string name) {
  const auto& tissue = std::get<TissueScene>(scene.body);
  check_tissue(tissue, scene.tool_count);
  const double there = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  // The 2 stands for the two masks, of one byte per cell each.
  const double needed = cells_of(tissue) * (static_cast<double>(sizeof(Real)) * scalar_arrays(features, tissue.method) + 2);
  if (needed > there) {
    throw SolverError(SolverFault::out_of_memory,
                      fmt::format("the scene needs {:.3g} bytes of memory, there are {:.3g}", needed, there),
                      "fewer particles");
  }
  return std::make_unique<CpuTissue<Real>>(scene, features, std::move(name));
}

}  // namespace

std::unique_ptr<Solver> make_cpu_tissue_float(const Scene& scene, const SceneFeatures& features) {
  return make_cpu_tissue<float>(scene, features, "cpu");
}
std::unique_ptr<Solver> make_cpu_tissue_double(const Scene& scene, const SceneFeatures& features) {
  return make_cpu_tissue<double>(scene, features, "cpu-double");
}

}  // namespace evenstep::internal
