#include "particles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "evenstep/catalogue/linear_map.h"

namespace evenstep::internal {
namespace {

using Real = LinearMap::Real;

constexpr double kDiverged = 1e3;  // diverged at so many times what a correct run can reach
constexpr double kSite_m = 1.0 / 128;

TissueScene chain(const CellSpec& cell, int sites) {
  TissueScene tissue;
  tissue.lattice = {sites, 1, 1};
  tissue.particle_count = sites;
  tissue.spacing_m = kSite_m;
  tissue.particle_mass_kg = 1e-3;
  tissue.fixed = FixedFaces::none();
  tissue.method = cell.method;
  tissue.iterations = cell.spec.iterations;
  tissue.substeps = 1;
  return tissue;
}

void put_error(CaseCell& cell, double error, double tolerance) {
  cell.metrics["error"] = error;
  if (error <= tolerance) return;
  cell.status = CellStatus::drifting;
  cell.shown = error;
}

/// S8: two bodies on a spring are released. The relative motion has the reduced mass, and the centre of mass must not move.
class MassRatioTrial final : public Trial {
 public:
  explicit MassRatioTrial(const CellSpec& cell) : ratio_(cell.value), is_float_(cell.is_float()) {
    TissueScene tissue = chain(cell, 2);
    light_kg_ = tissue.particle_mass_kg;
    heavy_kg_ = light_kg_ * ratio_;
    scene.step_rate = {1000, 1};
    const double h_s = period_s(scene.step_rate), reduced_kg = light_kg_ * (ratio_ / (1 + ratio_));
    tissue.stiffness_N_per_m = kStep * kStep * reduced_kg / (h_s * h_s);
    const double half = 0.5 * kSite_m;
    tissue.regions = {{{half, -half, -half}, {3 * half, half, half}, tissue.stiffness_N_per_m, heavy_kg_}};
    tissue.initial_displacement_m = {glm::dvec3(-0.25 * kSite_m, 0, 0), glm::dvec3(0)};
    const auto w2 =
        static_cast<Real>(tissue.stiffness_N_per_m) * (1 + 1 / static_cast<Real>(ratio_)) / static_cast<Real>(light_kg_);
    map_ = linear_map(cell.method, w2, 0, h_s);
    start_ = {0.25L * kSite_m, 0};
    stiffness_ = tissue.stiffness_N_per_m;
    bound_ = cell.method == Method::symplectic_euler ? 1 / (1 - kStep / 2) : 1;
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    steps = 2000;
  }
  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    const ParticleState state = solver.particle_state();
    const double x = state.displacement_m[1].x - state.displacement_m[0].x;
    const double v1 = state.velocity_m_per_s[0].x, v2 = state.velocity_m_per_s[1].x;
    if (!(std::abs(x) <= kDiverged * kSite_m)) return false;
    error_ = std::max(error_, std::abs(static_cast<double>(x - map_.power(static_cast<Real>(n), start_).x)) / kSite_m);
    momentum_ = std::max(momentum_, std::abs(light_kg_ * v1 + heavy_kg_ * v2));
    largest_ = std::max(largest_, light_kg_ * std::abs(v1) + heavy_kg_ * std::abs(v2));
    energy_ = std::max(energy_, (stiffness_ * x * x + light_kg_ * v1 * v1 + heavy_kg_ * v2 * v2) / 2);
    last_ = {x, v2 - v1};
    return true;
  }
  void judge(Solver&, CaseCell& cell) override {
    const auto x0 = static_cast<double>(start_.x);
    cell.metrics["momentum_error"] = momentum_ / largest_;
    cell.metrics["energy_over_bound"] = std::max(energy_ / (stiffness_ * x0 * x0 / 2), 1.0) / bound_;
    cell.metrics["closed_form_error"] = error_;
    const auto left = static_cast<double>(map_.invariant(last_) / map_.invariant(start_));
    cell.metrics["energy_left"] = cell.metrics["energy_left_min"] = left;
    put_error(cell, error_, is_float_ ? 1e-3 : 1e-10);
    if (!(left < 0.999)) return;
    cell.status = CellStatus::damped;
    cell.shown = left;
  }

 private:
  /// w h. At 1 a turn is exactly six steps, so the same roundings repeat in every turn and add up eightfold.
  static constexpr double kStep = 0.9;
  double ratio_, light_kg_ = 0, heavy_kg_ = 0, stiffness_ = 0, bound_ = 1;
  bool is_float_;
  LinearMap map_;
  LinearMap::State start_, last_;
  double error_ = 0, momentum_ = 0, largest_ = 1e-300, energy_ = 0;
};

/// S10: a particle between two spheres that push. Every bounce happens at another phase of the step; by physics all of them
/// have the restitution 1.
class WallTrial final : public Trial {
 public:
  explicit WallTrial(const CellSpec& cell) {
    TissueScene tissue = chain(cell, 1);
    tissue.particle_mass_kg = 0.01;
    for (const double side : {-1.0, 1.0})
      tissue.tools.push_back({{side * (kRadius_m + kGap_m), 0, 0}, kRadius_m, CouplingKind::probe, cell.value, 0});
    tissue.initial_velocity_m_per_s = {{kSpeed_m_per_s, 0, 0}};
    scene.body = std::move(tissue);
    scene.tool_count = 2;
    scene.step_rate = {1000, 1};
    scene.allow_unstable = cell.spec.allow_unstable;
    scene.needs_energy = false;
    // A flight takes 2 gap / speed = 41.3 steps, which is not a whole number, so the phases of the contacts are spread
    // evenly.
    steps = cell.spec.most_steps;
  }
  void hands(std::int64_t, std::span<glm::dvec3> positions_m) const override {
    std::fill(positions_m.begin(), positions_m.end(), glm::dvec3(0));
  }
  bool observe(std::int64_t, const ToolResponse& response, Solver& solver) override {
    const ParticleState state = solver.particle_state();
    const double v = state.velocity_m_per_s[0].x;
    if (!(std::abs(v) <= kDiverged * kSpeed_m_per_s)) return false;
    const bool touches =
        response.force_N[0].x != 0 || response.force_N[1].x != 0 || std::abs(state.displacement_m[0].x) > kGap_m;
    if (!touches && was_touching_) {
      const double restitution = std::abs(v) / before_;
      most_ = std::max(most_, restitution);
      least_ = std::min(least_, restitution);
      ++bounces_;
    }
    if (!touches) before_ = std::abs(v);
    was_touching_ = touches;
    return before_ > 0;
  }
  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["bounces_min"] = bounces_;
    if (bounces_ == 0) return;
    cell.metrics["restitution"] = most_;
    cell.metrics["restitution_min"] = least_;
    constexpr double kTolerance = 0.05;
    if (most_ > 1 + kTolerance) {
      cell.status = CellStatus::drifting;
      cell.shown = most_;
    } else if (least_ < 1 - kTolerance) {
      cell.status = CellStatus::damped;
      cell.shown = least_ * least_;
    }
  }

 private:
  static constexpr double kRadius_m = 0.05, kGap_m = 2.065e-3, kSpeed_m_per_s = 0.1;
  bool was_touching_ = false;
  double before_ = kSpeed_m_per_s, most_ = 0, least_ = 1e300;
  int bounces_ = 0;
};

/// S11: a particle that falls, far from its rest position. With symplectic Euler it falls by g h^2 n (n + 1) / 2, the exact
/// distance times 1 + 1 / n; with the others by g h^2 n^2 / 2 plus the error of their order.
class FreeFallTrial final : public Trial {
 public:
  explicit FreeFallTrial(const CellSpec& cell) : far_m_(cell.value) {
    TissueScene tissue = chain(cell, 1);
    tissue.gravity_m_per_s2 = {0, 0, -9.81};
    tissue.initial_displacement_m = {{0, 0, far_m_}};
    if (cell.is_float()) far_m_ = static_cast<float>(far_m_);
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    scene.step_rate = {1'000'000'000, cell.spec.step_size.ns};
    steps = 1000;
    observe_every = steps;
    const double h_s = period_s(scene.step_rate), n = static_cast<double>(steps);
    const bool late = cell.method == Method::symplectic_euler || cell.method == Method::implicit_euler ||
                      cell.method == Method::vertex_block_descent;
    exact_m_ = 9.81 * h_s * h_s * n * (late ? n + 1 : n) / 2;
    tolerance_ = cell.is_float() ? 2e-3 : 1e-9;
  }
  bool observe(std::int64_t, const ToolResponse&, Solver& solver) override {
    fallen_m_ = far_m_ - solver.particle_state().displacement_m[0].z;
    return std::isfinite(fallen_m_);
  }
  void judge(Solver&, CaseCell& cell) override { put_error(cell, std::abs(fallen_m_ / exact_m_ - 1), tolerance_); }

 private:
  double far_m_, exact_m_ = 1, fallen_m_ = 0, tolerance_ = 0;
};

/// S12: a chain that hangs from a hand, at rest: the tip is m g n (n + 1) / (2 k) lower, and the hand carries n m g.
class HangingTrial final : public Trial {
 public:
  explicit HangingTrial(const CellSpec& cell) : n_(static_cast<int>(cell.spec.particles)) {
    TissueScene tissue = chain(cell, n_ + 1);
    tissue.particle_mass_kg = kMass_kg;
    tissue.stiffness_N_per_m = cell.value;
    tissue.gravity_m_per_s2 = {kGravity_m_per_s2, 0, 0};
    tissue.tools = {{glm::dvec3(0), kSite_m / 2}};
    // Half the step limit of the stiffest mode, the slowest mode critically damped, and forty times its time constant to
    // come to rest.
    const double stiffest = 2 * std::sqrt(cell.value / kMass_kg);
    const double slowest = stiffest * std::sin(std::numbers::pi / (4 * n_ + 2.0));
    tissue.damping_per_s = 2 * slowest;
    scene.step_rate = {static_cast<std::int64_t>(std::ceil(stiffest)), 1};
    scene.tool_count = 1;
    steps = static_cast<std::int64_t>(40 / slowest * stiffest);
    observe_every = steps;
    stretch_m_ = kMass_kg * kGravity_m_per_s2 * n_ * (n_ + 1) / (2 * cell.value);
    tolerance_ = cell.is_float() ? 1e-2 : 1e-6;
    scene.body = std::move(tissue);
  }
  bool observe(std::int64_t, const ToolResponse& response, Solver& solver) override {
    const double tip_m = solver.particle_state().displacement_m[static_cast<std::size_t>(n_)].x;
    error_ = std::abs(tip_m / stretch_m_ - 1);
    reaction_error_ = std::abs(response.force_N[0].x / (n_ * kMass_kg * kGravity_m_per_s2) - 1);
    return std::isfinite(tip_m);
  }
  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["reaction_error"] = reaction_error_;
    put_error(cell, std::max(error_, reaction_error_), tolerance_);
    cell.metrics["error"] = error_;
  }

 private:
  static constexpr double kMass_kg = 1e-3, kGravity_m_per_s2 = 9.81;
  int n_;
  double stretch_m_ = 1, error_ = 0, reaction_error_ = 0, tolerance_ = 0;
};

/// S7: a virtual coupling pulls a particle behind a hand x = A (1 - cos t). The exact lag is -m x'' / K, plus a free
/// oscillation smaller than that. The remaining error divided by A must not grow with K.
class MovingTargetTrial final : public Trial {
 public:
  explicit MovingTargetTrial(const CellSpec& cell) {
    TissueScene tissue = chain(cell, 1);
    tissue.particle_mass_kg = 1e-3;
    // The damper is critical, so the oscillation that the start excites has decayed before anything is judged.
    const double damping = 2 * std::sqrt(cell.value * tissue.particle_mass_kg);
    tissue.tools = {{glm::dvec3(0), kSite_m / 2, CouplingKind::spring, cell.value, damping}};
    scene.body = std::move(tissue);
    scene.tool_count = 1;
    scene.step_rate = {1000, 1};
    // Half a turn: judged in its second half, in which the acceleration goes from nothing to all.
    steps = static_cast<std::int64_t>(std::numbers::pi / period_s(scene.step_rate));
  }
  void hands(std::int64_t n, std::span<glm::dvec3> positions_m) const override {
    positions_m[0] = {kTravel_m * (1 - std::cos(period_s(scene.step_rate) * static_cast<double>(n))), 0, 0};
  }
  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    // Step n - 1 ends with the hand at this position.
    std::array<glm::dvec3, 1> hand_m{};
    hands(n - 1, hand_m);
    const double off_m = std::abs(solver.particle_state().displacement_m[0].x - hand_m[0].x);
    if (!(off_m <= kDiverged * kTravel_m)) return false;
    if (2 * n > steps) error_ = std::max(error_, off_m / kTravel_m);
    return true;
  }
  void judge(Solver&, CaseCell& cell) override { put_error(cell, error_, 1); }

 private:
  static constexpr double kTravel_m = 1e-2;
  double error_ = 0;
};

/// S15: a sphere is pressed onto a particle on a spring, and held. At rest the force is the travel times the two stiffnesses
/// in series, whatever the step is.
class PressTrial final : public Trial {
 public:
  explicit PressTrial(const CellSpec& cell) {
    TissueScene tissue = chain(cell, 2);
    tissue.fixed.x_min = true;
    tissue.stiffness_N_per_m = kSpring_N_per_m;
    tissue.damping_per_s = 0.2 * std::sqrt((kSpring_N_per_m + kProbe_N_per_m) / tissue.particle_mass_kg);
    tissue.tools = {{{kSite_m + kRadius_m, 0, 0}, kRadius_m, CouplingKind::probe, kProbe_N_per_m, 0}};
    scene.body = std::move(tissue);
    scene.tool_count = 1;
    scene.step_rate = {static_cast<std::int64_t>(1000 * cell.value), 1};
    steps = static_cast<std::int64_t>(1000 * cell.value);
    observe_every = steps;
    tolerance_ = cell.is_float() ? 1e-3 : 1e-9;
  }
  void hands(std::int64_t n, std::span<glm::dvec3> positions_m) const override {
    const double t_s = period_s(scene.step_rate) * static_cast<double>(n);
    positions_m[0] = {-kTravel_m * std::min(1.0, t_s / kPress_s), 0, 0};
  }
  bool observe(std::int64_t, const ToolResponse& response, Solver&) override {
    force_N_ = response.force_N[0].x;
    return std::isfinite(force_N_);
  }
  void judge(Solver&, CaseCell& cell) override {
    const double exact_N = kTravel_m * kSpring_N_per_m * kProbe_N_per_m / (kSpring_N_per_m + kProbe_N_per_m);
    put_error(cell, std::abs(force_N_ / exact_N - 1), tolerance_);
  }

 private:
  static constexpr double kSpring_N_per_m = 200, kProbe_N_per_m = 600, kTravel_m = 1e-3, kPress_s = 0.1, kRadius_m = 0.05;
  double force_N_ = 0, tolerance_ = 0;
};

}  // namespace

std::unique_ptr<Trial> make_mass_ratio(const CellSpec& cell) { return std::make_unique<MassRatioTrial>(cell); }
std::unique_ptr<Trial> make_wall(const CellSpec& cell) { return std::make_unique<WallTrial>(cell); }
std::unique_ptr<Trial> make_free_fall(const CellSpec& cell) { return std::make_unique<FreeFallTrial>(cell); }
std::unique_ptr<Trial> make_hanging_chain(const CellSpec& cell) { return std::make_unique<HangingTrial>(cell); }
std::unique_ptr<Trial> make_moving_target(const CellSpec& cell) { return std::make_unique<MovingTargetTrial>(cell); }
std::unique_ptr<Trial> make_press(const CellSpec& cell) { return std::make_unique<PressTrial>(cell); }

}  // namespace evenstep::internal
