#include "oscillator.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace evenstep::internal {
namespace {

constexpr double kSpacing_m = 1.0 / 128;
constexpr double kLost =
    1e3;  // diverged at so many times its reach. (A spring inside out is softer: 2.0001 ends at 25,000.)
constexpr double kReach_m = kSpacing_m / 2;  // of the motion, so that the spring keeps its direction and is linear

/// Compares the particle with the n-th power of the matrix of its method.
class OscillatorTrial final : public Trial {
 public:
  OscillatorTrial(const CellSpec& cell, double stiffness_N_per_m, std::int64_t step_count) {
    TissueScene tissue = oscillator_scene(cell, stiffness_N_per_m);
    mass_kg_ = tissue.particle_mass_kg;
    w2_ = static_cast<LinearMap::Real>(stiffness_N_per_m) / static_cast<LinearMap::Real>(mass_kg_);
    const double h_s = period_s(kOscillatorRate);
    map_ = cell.is_float() ? float_linear_map(cell.method, stiffness_N_per_m, mass_kg_, h_s)
                           : linear_map(cell.method, w2_, 0, h_s);
    // The largest excursion of the discrete motion is kReach_m.
    start_.x = kReach_m / (map_.oscillates() ? map_.amplitude({1, 0}) : 1);
    tissue.initial_displacement_m = {glm::dvec3(0), glm::dvec3(static_cast<double>(start_.x), 0, 0)};
    // Rounded as the solver stores it.
    if (cell.is_float()) tissue.initial_displacement_m[1].x = static_cast<float>(tissue.initial_displacement_m[1].x);
    start_.x = tissue.initial_displacement_m[1].x;
    start_energy_ = energy(start_);
    // Symplectic Euler starts at the small end of its ellipse; the energy of the other methods never exceeds that of the
    // start.
    const LinearMap::Real z = std::sqrt(w2_) * h_s;
    energy_bound_ = cell.method == Method::symplectic_euler && z < 2 ? 1 / (1 - z / 2) : 1;
    tolerance_ = cell.is_float() ? 1e-3 : 1e-10;
    scene.body = std::move(tissue);
    scene.step_rate = kOscillatorRate;
    scene.tool_count = 0;
    scene.allow_unstable = cell.spec.allow_unstable;
    steps = step_count;
    observe_every = cell.spec.allow_unstable ? 1 : std::max<std::int64_t>(1, steps / 10'000);
  }

  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    const ParticleState state = solver.particle_state();
    last_ = {state.displacement_m[1].x, state.velocity_m_per_s[1].x};
    if (!std::isfinite(state.velocity_m_per_s[1].x) || !(std::abs(last_.x) <= kLost * kReach_m)) return false;
    const LinearMap::State exact = map_.power(static_cast<LinearMap::Real>(n), start_);
    error_ = std::max(error_, std::abs(last_.x - exact.x) / kReach_m);
    most_energy_ = std::max(most_energy_, energy(last_) / start_energy_);
    return true;
  }

  void judge(Solver&, CaseCell& cell) override {
    const auto left = static_cast<double>(map_.oscillates() ? map_.invariant(last_) / map_.invariant(start_) : 1);
    cell.metrics["closed_form_error"] = static_cast<double>(error_);
    cell.metrics["energy_over_bound"] = static_cast<double>(std::max(most_energy_, 1.0L) / energy_bound_);
    cell.metrics["energy_left"] = cell.metrics["energy_left_min"] = left;
    if (left < 1 - kEnergyTolerance) {
      cell.status = CellStatus::damped;
      cell.shown = left;
    } else if (!(error_ <= tolerance_)) {
      cell.status = CellStatus::drifting;
      cell.shown = static_cast<double>(error_);
    }
  }

 private:
  LinearMap::Real energy(LinearMap::State z) const { return (w2_ * z.x * z.x + z.v * z.v) * mass_kg_ / 2; }

  static constexpr double kEnergyTolerance = 1e-3;
  LinearMap map_;
  LinearMap::State start_, last_;
  LinearMap::Real w2_ = 0, start_energy_ = 0, energy_bound_ = 1, error_ = 0, most_energy_ = 0;
  double mass_kg_ = 0, tolerance_ = 0;
};

/// S6: the same from rest with drag, compared with the matrix of the method and with the exact decay.
class DampingTrial final : public Trial {
 public:
  explicit DampingTrial(const CellSpec& cell) {
    const double h_s = period_s(kOscillatorRate), w_per_s = kStep / h_s, damping_per_s = 2 * cell.value * w_per_s;
    TissueScene tissue = oscillator_scene(cell, kOscillatorMass_kg * w_per_s * w_per_s);
    tissue.damping_per_s = damping_per_s;
    tissue.initial_displacement_m = {glm::dvec3(0), glm::dvec3(kReach_m, 0, 0)};
    const LinearMap::Real w2 = tissue.stiffness_N_per_m / static_cast<LinearMap::Real>(tissue.particle_mass_kg);
    map_ = damped_map(cell.method, w2, damping_per_s, h_s);
    exact_ = exact_map(w2, damping_per_s, h_s);
    tolerance_ = cell.is_float() ? 1e-3 : 1e-10;
    scene.body = std::move(tissue);
    scene.step_rate = kOscillatorRate;
    scene.tool_count = 0;
    steps = std::max<std::int64_t>(1, std::llround(cell.spec.duration_s / h_s));
  }

  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    const LinearMap::Real x = solver.particle_state().displacement_m[1].x, count = static_cast<LinearMap::Real>(n);
    if (!(std::abs(x) <= kLost * kReach_m)) return false;
    discrete_error_ = std::max(discrete_error_, std::abs(x - map_.power(count, discrete_start_).x) / kReach_m);
    error_ = std::max(error_, std::abs(x - exact_.power(count, {kReach_m, 0}).x) / kReach_m);
    return true;
  }

  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["closed_form_error"] = static_cast<double>(discrete_error_);
    cell.metrics["error"] = static_cast<double>(error_);
    if (discrete_error_ <= tolerance_) return;
    cell.status = CellStatus::drifting;
    cell.shown = static_cast<double>(discrete_error_);
  }

 private:
  /// Velocity Verlet evaluates the drag at the half step's velocity. So with that velocity, (x, v) moves as in symplectic
  /// Euler, starting from the v that half a step with the first acceleration leads to.
  LinearMap damped_map(Method method, LinearMap::Real w2, LinearMap::Real damping_per_s, LinearMap::Real h_s) {
    if (method != Method::velocity_verlet) return linear_map(method, w2, damping_per_s, h_s);
    discrete_start_.v = h_s * w2 * discrete_start_.x / (2 * (1 - h_s * damping_per_s));
    return linear_map(Method::symplectic_euler, w2, damping_per_s, h_s);
  }

  static constexpr double kStep = 0.01;  // w h
  LinearMap::State discrete_start_{kReach_m, 0};
  LinearMap map_, exact_;
  LinearMap::Real discrete_error_ = 0, error_ = 0;
  double tolerance_ = 0;
};

}  // namespace

TissueScene oscillator_scene(const CellSpec& cell, double stiffness_N_per_m) {
  TissueScene tissue;
  tissue.lattice = {2, 1, 1};
  tissue.particle_count = 2;
  tissue.spacing_m = kSpacing_m;
  tissue.particle_mass_kg = kOscillatorMass_kg;
  tissue.stiffness_N_per_m = stiffness_N_per_m;
  tissue.fixed = FixedFaces::none();
  tissue.fixed.x_min = true;
  tissue.method = cell.method;
  tissue.iterations = cell.spec.iterations;
  tissue.substeps = 1;
  return tissue;
}

std::unique_ptr<Trial> make_oscillator(const CellSpec& cell) {
  const double w_per_s = cell.value / period_s(kOscillatorRate);
  const double steps = std::ceil(cell.spec.periods * 2 * std::numbers::pi / cell.value);
  const auto most = static_cast<double>(cell.spec.most_steps);
  return std::make_unique<OscillatorTrial>(cell, kOscillatorMass_kg * w_per_s * w_per_s,
                                           static_cast<std::int64_t>(std::clamp(steps, 1.0, most)));
}

std::unique_ptr<Trial> make_stiffness_decades(const CellSpec& cell) {
  const double steps = std::round(cell.spec.duration_s / period_s(kOscillatorRate));
  return std::make_unique<OscillatorTrial>(cell, cell.value, std::max<std::int64_t>(1, static_cast<std::int64_t>(steps)));
}

std::unique_ptr<Trial> make_damping_decades(const CellSpec& cell) { return std::make_unique<DampingTrial>(cell); }

}  // namespace evenstep::internal
