// The reference: the arithmetic of opencl/kernels/*.cl, operation by operation and in the same order, for float and double.
#include <bit>
#include <cmath>
#include <utility>

#include "cpu/cpu_solvers.h"
#include "evenstep/time/digest.h"
#include "src/tissue_solver.h"

namespace evenstep::internal {
namespace {

/// Structure of arrays, one entry per cell.
template <class Real>
struct Field {
  explicit Field(std::size_t cells) : x(cells), y(cells), z(cells) {}
  std::vector<Real> x, y, z;
  void clear() {
    for (std::vector<Real>* component : {&x, &y, &z}) std::fill(component->begin(), component->end(), Real{0});
  }
};

template <class Real>
struct Force {
  Real x{0}, y{0}, z{0};
};

std::uint64_t bits(float value) { return std::bit_cast<std::uint32_t>(value); }
std::uint64_t bits(double value) { return std::bit_cast<std::uint64_t>(value); }

template <class Real>
class CpuTissue final : public TissueSolver {
 public:
  CpuTissue(const Scene& given, std::string name)
      : TissueSolver(given, std::move(name)), constants_(scene(), substep_s()), now_(lattice().cells), next_(lattice().cells),
        velocity_(lattice().cells), active_(lattice().active.begin(), lattice().active.end()),
        mobile_(lattice().mobile.begin(), lattice().mobile.end()) {}

  std::uint64_t state_digest() override {
    std::uint64_t digest = kDigestStart;
    for (std::size_t chunk = 0; chunk < lattice().span; chunk += kChunk) {
      std::uint64_t sum = 0;
      for (std::size_t i = chunk; i < chunk + kChunk; ++i) sum += cell_digest(i);
      digest = mix(digest, sum);
    }
    return digest;
  }

 protected:
  void substep(std::span<const GrabTarget> targets) override {
    const std::size_t first = lattice().first;
    for (std::size_t i = first; i < first + lattice().span; ++i) {
      const Force<Real> f = spring_force(i);
      const Real acceleration = constants_.acceleration * mobile_[i], h = constants_.step_s * mobile_[i];
      velocity_.x[i] = velocity_.x[i] * constants_.decay + f.x * acceleration;
      velocity_.y[i] = velocity_.y[i] * constants_.decay + f.y * acceleration;
      velocity_.z[i] = velocity_.z[i] * constants_.decay + f.z * acceleration;
      next_.x[i] = now_.x[i] + velocity_.x[i] * h;
      next_.y[i] = now_.y[i] + velocity_.y[i] * h;
      next_.z[i] = now_.z[i] + velocity_.z[i] * h;
    }
    std::swap(now_, next_);
    for (std::size_t tool = 0; tool < targets.size(); ++tool) {
      for (const std::uint32_t i : lattice().grabbed[tool]) {
        now_.x[i] = static_cast<Real>(targets[tool].offset_m[0]);
        now_.y[i] = static_cast<Real>(targets[tool].offset_m[1]);
        now_.z[i] = static_cast<Real>(targets[tool].offset_m[2]);
        velocity_.x[i] = static_cast<Real>(targets[tool].velocity_m_per_s[0]);
        velocity_.y[i] = static_cast<Real>(targets[tool].velocity_m_per_s[1]);
        velocity_.z[i] = static_cast<Real>(targets[tool].velocity_m_per_s[2]);
      }
    }
  }

  void grab_forces(std::span<std::array<double, 3>> forces_N) override {
    std::size_t n = 0;
    for (const auto& cells : lattice().grabbed) {
      for (const std::uint32_t i : cells) {
        const Force<Real> f = spring_force(i);
        forces_N[n++] = {f.x * constants_.stiffness_N_per_m, f.y * constants_.stiffness_N_per_m, f.z * constants_.stiffness_N_per_m};
      }
    }
  }

  double energy() override {
    double total = 0;
    for (std::size_t chunk = 0; chunk < lattice().span; chunk += kChunk) {
      Real sum = 0;
      for (std::size_t i = chunk; i < chunk + kChunk; ++i) sum += cell_energy(lattice().first + i);
      total += sum;
    }
    return total;
  }

  void to_rest() override {
    now_.clear();
    next_.clear();
    velocity_.clear();
  }

 private:
  /// Sum over the 18 springs of (1 - L / len) d: the force over k. d = (u_j - u_i) + r keeps the digits that positions far
  /// from the origin would lose.
  Force<Real> spring_force(std::size_t i) const {
    Force<Real> f;
    for (std::size_t s = 0; s < kNeighbours; ++s) {
      const std::size_t j = i + static_cast<std::size_t>(lattice().offset[s]);
      const Real dx = (now_.x[j] - now_.x[i]) + constants_.rest_m[s][0];
      const Real dy = (now_.y[j] - now_.y[i]) + constants_.rest_m[s][1];
      const Real dz = (now_.z[j] - now_.z[i]) + constants_.rest_m[s][2];
      const Real length = std::sqrt(dx * dx + dy * dy + dz * dz);
      const Real factor = active_[j] > 0 ? Real{1} - constants_.length_m[s] / length : Real{0};
      f.x += factor * dx;
      f.y += factor * dy;
      f.z += factor * dz;
    }
    return f;
  }

  std::uint64_t cell_digest(std::size_t index) const {
    const std::size_t i = lattice().first + index;
    std::uint64_t h = index * 0x9e3779b97f4a7c15ULL;
    h += bits(now_.x[i]) * 0xff51afd7ed558ccdULL;
    h += bits(now_.y[i]) * 0xc4ceb9fe1a85ec53ULL;
    h += bits(now_.z[i]) * 0xbf58476d1ce4e5b9ULL;
    h += bits(velocity_.x[i]) * 0x94d049bb133111ebULL;
    h += bits(velocity_.y[i]) * 0xd6e8feb86659fd93ULL;
    h += bits(velocity_.z[i]) * 0xa0761d6478bd642fULL;
    h ^= h >> 32;
    h *= 0xe7037ed1a0b428dbULL;
    return h ^ (h >> 29);
  }

  /// Kinetic energy of a particle and half of each of its springs' energy, k (len - L)^2 / 2.
  Real cell_energy(std::size_t i) const {
    Real springs = 0;
    for (std::size_t s = 0; s < kNeighbours; ++s) {
      const std::size_t j = i + static_cast<std::size_t>(lattice().offset[s]);
      const Real dx = (now_.x[j] - now_.x[i]) + constants_.rest_m[s][0];
      const Real dy = (now_.y[j] - now_.y[i]) + constants_.rest_m[s][1];
      const Real dz = (now_.z[j] - now_.z[i]) + constants_.rest_m[s][2];
      const Real stretch = std::sqrt(dx * dx + dy * dy + dz * dz) - constants_.length_m[s];
      springs += active_[j] > 0 ? stretch * stretch : Real{0};
    }
    const Real speed2 = velocity_.x[i] * velocity_.x[i] + velocity_.y[i] * velocity_.y[i] + velocity_.z[i] * velocity_.z[i];
    const Real energy = constants_.mass_kg * Real(0.5) * speed2 + constants_.stiffness_N_per_m * Real(0.25) * springs;
    return active_[i] > 0 ? energy : Real{0};
  }

  TissueConstants<Real> constants_;
  Field<Real> now_, next_, velocity_;   // displacement from rest, m; m/s
  std::vector<Real> active_, mobile_;   // 1 or 0
};

}  // namespace

std::unique_ptr<Solver> make_cpu_tissue_float(const Scene& scene) { return std::make_unique<CpuTissue<float>>(scene, "cpu"); }
std::unique_ptr<Solver> make_cpu_tissue_double(const Scene& scene) { return std::make_unique<CpuTissue<double>>(scene, "cpu-double"); }

}  // namespace evenstep::internal
