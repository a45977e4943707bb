#include "chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "evenstep/catalogue/linear_map.h"

namespace evenstep::internal {
namespace {

constexpr double kRest_m = 5e-3, kMass_kg = 1.25e-4, kStiffness_N_per_m = 50;  // as the paper's tissue
constexpr int kModes = 3;
constexpr double kMode_m = kRest_m;  // three such modes strain a chain of 16 or more by less than 1, so it stays linear

/// n particles between two fixed ones.
TissueScene fixed_chain(const CellSpec& cell, int n) {
  TissueScene tissue;
  tissue.lattice = {n + 2, 1, 1};
  tissue.particle_count = n + 2;
  tissue.spacing_m = kRest_m;
  tissue.particle_mass_kg = kMass_kg;
  tissue.stiffness_N_per_m = kStiffness_N_per_m;
  tissue.fixed = FixedFaces::none();
  tissue.fixed.x_min = tissue.fixed.x_max = true;
  tissue.method = cell.method;
  tissue.iterations = cell.spec.iterations;
  tissue.substeps = 1;
  return tissue;
}

/// Modes 1 to 3 are released from rest. At the end the state is compared with the exact motion, which shows the order of the
/// method, and with the powers of its matrix, which shows that it really is this method.
class ChainTrial final : public Trial {
 public:
  explicit ChainTrial(const CellSpec& cell) : n_(static_cast<int>(cell.spec.particles)), duration_s_(cell.spec.duration_s) {
    const double longest_s = 2 / std::sqrt(chain_w2_per_s2(n_, n_, kStiffness_N_per_m, kMass_kg));
    steps = static_cast<std::int64_t>(std::ceil(duration_s_ / longest_s)) << static_cast<int>(cell.value);
    const auto duration_ns = static_cast<std::int64_t>(std::llround(duration_s_ * 1e9));
    scene.step_rate = {steps * 1'000'000'000, duration_ns};
    observe_every = steps;
    scene.body = chain_scene(cell);
    scene.tool_count = 0;
    method_ = cell.method;
    tolerance_ = cell.is_float() ? 1e-3 : 1e-9;
  }

  bool observe(std::int64_t, const ToolResponse&, Solver& solver) override {
    const ParticleState state = solver.particle_state();
    const LinearMap::Real h_s = period_s(scene.step_rate);
    std::array<double, kModes> exact{}, discrete{};  // amplitude of each mode, 1 at the start
    for (int p = 1; p <= kModes; ++p) {
      const LinearMap::Real w2 = chain_w2_per_s2(n_, p, kStiffness_N_per_m, kMass_kg);
      const auto mode = static_cast<std::size_t>(p - 1);
      exact[mode] = static_cast<double>(exact_map(w2, 0, h_s * steps).times({1, 0}).x);
      discrete[mode] = static_cast<double>(linear_map(method_, w2, 0, h_s).power(steps, {1, 0}).x);
    }
    for (std::size_t i = 1; i <= static_cast<std::size_t>(n_); ++i) {
      const double x_m = state.displacement_m[i].x;
      if (!(std::abs(x_m) <= 1e6 * kMode_m)) return false;
      error_ = std::max(error_, std::abs(x_m - sum(i, exact)));
      discrete_error_ = std::max(discrete_error_, std::abs(x_m - sum(i, discrete)));
    }
    return true;
  }

  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["error"] = error_ / kMode_m;
    cell.metrics["closed_form_error"] = discrete_error_ / kMode_m;
    cell.metrics["step_s"] = period_s(scene.step_rate);
    if (cell.metrics["closed_form_error"] <= tolerance_) return;
    cell.status = CellStatus::drifting;
    cell.shown = cell.metrics["closed_form_error"];
  }

 private:
  TissueScene chain_scene(const CellSpec& cell) const;
  /// The displacement of particle i if the modes have these amplitudes, relative to those at the start.
  double sum(std::size_t i, const std::array<double, kModes>& modes) const {
    double x_m = 0;
    for (std::size_t p = 1; p <= kModes; ++p)
      x_m += kMode_m * modes[p - 1] * std::sin(std::numbers::pi * static_cast<double>(p * i) / (n_ + 1));
    return x_m;
  }

  int n_;
  double duration_s_;
  Method method_ = Method::symplectic_euler;
  double error_ = 0, discrete_error_ = 0, tolerance_ = 0;
};

TissueScene ChainTrial::chain_scene(const CellSpec& cell) const {
  TissueScene tissue = fixed_chain(cell, n_);
  tissue.initial_displacement_m.resize(static_cast<std::size_t>(n_) + 2);
  for (std::size_t i = 1; i <= static_cast<std::size_t>(n_); ++i) tissue.initial_displacement_m[i].x = sum(i, {1, 1, 1});
  return tissue;
}

/// S13: a standing wave of about twenty cells. Its angle per step says how fast waves of that length run.
class WaveTrial final : public Trial {
 public:
  explicit WaveTrial(const CellSpec& cell) : n_(static_cast<int>(cell.spec.particles)) {
    mode_ = (n_ + 1) / 10;
    TissueScene tissue = fixed_chain(cell, n_);
    const double h_s = period_s(scene.step_rate = {1000, 1});
    tissue.stiffness_N_per_m = tissue.particle_mass_kg * cell.value * cell.value / (h_s * h_s);
    tissue.initial_displacement_m.resize(static_cast<std::size_t>(n_) + 2);
    for (std::size_t i = 1; i <= static_cast<std::size_t>(n_); ++i) tissue.initial_displacement_m[i].x = kWave_m * shape(i);
    const double w2 = chain_w2_per_s2(n_, mode_, tissue.stiffness_N_per_m, tissue.particle_mass_kg);
    map_ = linear_map(cell.method, w2, 0, h_s);
    const double wave_number = mode_ * std::numbers::pi / (n_ + 1);  // per cell
    sound_angle_ = wave_number * cell.value;                         // per step, if all waves had the same speed
    tolerance_ = cell.is_float() ? 1e-3 : 1e-9;
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    steps = cell.spec.most_steps;
  }

  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    const ParticleState state = solver.particle_state();
    double amplitude = 0;
    for (std::size_t i = 1; i <= static_cast<std::size_t>(n_); ++i) amplitude += state.displacement_m[i].x * shape(i);
    amplitude *= 2 / ((n_ + 1) * kWave_m);
    if (!(std::abs(amplitude) <= 1e3)) return false;
    error_ =
        std::max(error_, std::abs(amplitude - static_cast<double>(map_.power(static_cast<LinearMap::Real>(n), {1, 0}).x)));
    // a[n+1] + a[n-1] = 2 cos(theta) a[n], by least squares.
    if (n > 2) {
      cross_ += before_ * (amplitude + before_that_);
      square_ += before_ * before_;
    }
    before_that_ = before_;
    before_ = amplitude;
    return true;
  }

  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["closed_form_error"] = error_;
    if (map_.determinant == 1) cell.metrics["speed_error"] = std::abs(std::acos(cross_ / (2 * square_)) / sound_angle_ - 1);
    if (map_.determinant < 1 && error_ <= tolerance_) {
      cell.status = CellStatus::damped;
      cell.shown = static_cast<double>(std::pow(map_.determinant, static_cast<LinearMap::Real>(steps)));
    } else if (error_ > tolerance_) {
      cell.status = CellStatus::drifting;
      cell.shown = error_;
    }
  }

 private:
  double shape(std::size_t i) const { return std::sin(std::numbers::pi * mode_ * static_cast<double>(i) / (n_ + 1)); }

  static constexpr double kWave_m = kRest_m;  // strains the chain by less than a third
  int n_, mode_;
  LinearMap map_;
  double sound_angle_ = 1, tolerance_ = 0, error_ = 0, before_ = 0, before_that_ = 0, cross_ = 0, square_ = 0;
};

}  // namespace

double chain_w2_per_s2(int n, int mode, double stiffness_N_per_m, double particle_mass_kg) {
  const double half_angle_sine = std::sin(mode * std::numbers::pi / (2 * (n + 1.0)));
  return 4 * stiffness_N_per_m / particle_mass_kg * half_angle_sine * half_angle_sine;
}

std::unique_ptr<Trial> make_wave(const CellSpec& cell) { return std::make_unique<WaveTrial>(cell); }

std::unique_ptr<Trial> make_chain_order(const CellSpec& cell) { return std::make_unique<ChainTrial>(cell); }

/// The order: log of the ratio of two errors divided by that of their steps. Left out where the errors are only rounding.
void compare_chain_orders(std::span<CaseCell> cells) {
  constexpr double kFloor = 1e-10;
  for (std::size_t c = 1; c < cells.size(); ++c) {
    const std::map<std::string, double>&coarse = cells[c - 1].metrics, &fine = cells[c].metrics;
    if (!coarse.contains("error") || !fine.contains("error") || fine.at("error") < kFloor) continue;
    const double order = std::log(coarse.at("error") / fine.at("error")) / std::log(coarse.at("step_s") / fine.at("step_s"));
    cells[c].metrics["order"] = cells[c].metrics["order_min"] = order;
  }
}

}  // namespace evenstep::internal
