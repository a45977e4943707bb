#include "blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "evenstep/sim/stability.h"

namespace evenstep::internal {
namespace {

constexpr double kRunAway = 1e3;

TissueScene block(const CellSpec& cell, int edge) {
  TissueScene tissue;
  tissue.lattice = {edge, edge, edge};
  tissue.particle_count = static_cast<std::int64_t>(edge) * edge * edge;
  tissue.method = cell.method;
  tissue.iterations = cell.spec.iterations;
  tissue.substeps = 1;
  return tissue;
}

double largest(const std::vector<glm::dvec3>& vectors) {
  double most = 0;
  for (const glm::dvec3& v : vectors) {
    const double length = glm::length(v);
    if (!std::isfinite(length)) return INFINITY;
    most = std::max(most, length);
  }
  return most;
}

/// The site at these coordinates, or -1.
std::int64_t site_at(const TissueScene& scene, std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto [nx, ny, nz] = scene.lattice;
  return x < 0 || y < 0 || z < 0 || x >= nx || y >= ny || z >= nz ? -1 : x + nx * (y + static_cast<std::int64_t>(ny) * z);
}

/// y = K x for the block at rest, where each spring resists only along its own direction.
void apply_rest_stiffness(const TissueScene& scene, const std::vector<glm::dvec3>& x, std::vector<glm::dvec3>& y) {
  const auto [nx, ny, nz] = scene.lattice;
  const auto layer = static_cast<std::int64_t>(nx) * ny;
  for (std::int64_t site = 0; site < scene.particle_count; ++site) {
    glm::dvec3 sum(0);
    const std::int64_t px = site % nx, py = site / nx % ny, pz = site / layer;
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dz = -1; dz <= 1; ++dz) {
          const int axes = dx * dx + dy * dy + dz * dz;
          const std::int64_t other = site_at(scene, px + dx, py + dy, pz + dz);
          if (axes < 1 || axes > 2 || other < 0) continue;
          const glm::dvec3 n = glm::dvec3(dx, dy, dz) / std::sqrt(axes);
          sum += n * glm::dot(n, x[static_cast<std::size_t>(site)] - x[static_cast<std::size_t>(other)]);
        }
      }
    }
    const bool fixed = scene.fixed.z_min && site < layer;
    y[static_cast<std::size_t>(site)] = fixed ? glm::dvec3(0) : sum * (scene.stiffness_N_per_m / scene.particle_mass_kg);
  }
}

/// S4: a block shaken a little, above and below the stiffness that its own largest eigenvalue allows.
class EdgeTrial final : public Trial {
 public:
  explicit EdgeTrial(const CellSpec& cell) {
    TissueScene tissue = block(cell, static_cast<int>(cell.spec.particles));
    scene.step_rate = {5000, 1};
    // lambda is proportional to k, and the step limit to 1 / sqrt(lambda). This is the k whose limit is this step, times the
    // value.
    const double limit_s = largest_stable_step_s(cell.method, rest_lambda_per_s2(tissue, cell.interrupted), 0),
                 h_s = period_s(scene.step_rate);
    tissue.stiffness_N_per_m *= cell.value * (limit_s / h_s) * (limit_s / h_s);
    amplitude_m_ = 1e-6 * tissue.spacing_m;  // so small that the block is linear even at a thousand times this
    tissue.initial_displacement_m = shaken(tissue, amplitude_m_);
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    scene.allow_unstable = true;  // the limit that holds in every configuration is lower
    steps = cell.spec.most_steps;
    observe_every = 10;
  }
  bool observe(std::int64_t, const ToolResponse&, Solver& solver) override {
    return largest(solver.particle_state().displacement_m) <= kRunAway * amplitude_m_;
  }
  void judge(Solver&, CaseCell&) override {}

 private:
  double amplitude_m_ = 0;
};

/// S9: a few stiff springs in the middle of a soft block. The step limit must follow their stiffness, and name one of their
/// particles.
class StiffInSoftTrial final : public Trial {
 public:
  explicit StiffInSoftTrial(const CellSpec& cell) : ratio_(cell.value) {
    TissueScene tissue = block(cell, 6);
    soft_limit_s_ = step_limit(tissue).step_s;
    const double low = 1.5 * tissue.spacing_m, high = 3.5 * tissue.spacing_m;
    tissue.regions = {{{low, low, low}, {high, high, high}, tissue.stiffness_N_per_m * ratio_, tissue.particle_mass_kg}};
    tissue.initial_displacement_m = shaken(tissue, 1e-3 * tissue.spacing_m);
    tissue.substeps = 0;
    amplitude_m_ = tissue.spacing_m;
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    scene.step_rate = {1000, 1};
    steps = 2;
  }
  bool observe(std::int64_t, const ToolResponse&, Solver& solver) override {
    return largest(solver.particle_state().displacement_m) <= kRunAway * amplitude_m_;
  }
  void judge(Solver& solver, CaseCell& cell) override {
    const auto& limit = solver.info().limit;
    if (!limit || !std::isfinite(limit->step_s)) return;
    cell.metrics["limit_scaling"] = cell.metrics["limit_scaling_min"] = limit->step_s / soft_limit_s_ * std::sqrt(ratio_);
    const std::int64_t x = limit->particle % 6, y = limit->particle / 6 % 6, z = limit->particle / 36;
    const auto inside = [](std::int64_t at) { return at >= 2 && at <= 3; };
    cell.metrics["stiffest_named_min"] = ratio_ == 1 || (inside(x) && inside(y) && inside(z)) ? 1 : 0;
  }

 private:
  double ratio_, soft_limit_s_ = 1, amplitude_m_ = 0;
};

/// S14: a free block over a long time. Its energy may swing, but must not climb.
class EnergyTrial final : public Trial {
 public:
  explicit EnergyTrial(const CellSpec& cell) {
    TissueScene tissue = block(cell, 4);
    tissue.fixed = FixedFaces::none();
    const double h_s = cell.value * 2 / std::sqrt(rest_lambda_per_s2(tissue, cell.interrupted));
    scene.step_rate = {static_cast<std::int64_t>(std::llround(1e6 / h_s)), 1'000'000};
    tissue.initial_displacement_m = shaken(tissue, 1e-4 * tissue.spacing_m);
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    scene.needs_energy = true;
    scene.allow_unstable = true;  // the limit at rest is what counts for motions this small
    steps = cell.spec.most_steps;
  }
  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    const double energy_J = solver.verdict().energy_J;
    if (n == 1) first_J_ = energy_J;
    if (!(energy_J <= kRunAway * first_J_)) return false;
    Half& half = halves_[2 * n > steps ? 1 : 0];
    half.sum_J += energy_J;
    half.squares += energy_J * energy_J;
    half.count += 1;
    return true;
  }
  void judge(Solver&, CaseCell& cell) override {
    const double first = halves_[0].sum_J / halves_[0].count, second = halves_[1].sum_J / halves_[1].count;
    const double squares = (halves_[0].squares + halves_[1].squares) / (halves_[0].count + halves_[1].count);
    const double mean = (halves_[0].sum_J + halves_[1].sum_J) / (halves_[0].count + halves_[1].count);
    const double swing = std::sqrt(std::max(0.0, squares - mean * mean)) / mean;
    cell.metrics["energy_swing"] = swing;
    cell.metrics["energy_trend"] = std::abs(second / first - 1);
    if (second < 0.99 * first) {
      cell.status = CellStatus::damped;
      cell.shown = second / first;
    } else if (second > 1.01 * first) {
      cell.status = CellStatus::drifting;
      cell.shown = second / first - 1;
    }
  }

 private:
  struct Half {
    double sum_J = 0, squares = 0, count = 0;
  };
  std::array<Half, 2> halves_;
  double first_J_ = 0;
};

/// S17: a block whose particles start at random places. It must stay finite and calm down. (For springs a cell and its
/// mirror image are the same, so it may come to rest inside out.)
class CrushedTrial final : public Trial {
 public:
  explicit CrushedTrial(const CellSpec& cell) {
    TissueScene tissue = block(cell, 5);
    amplitude_m_ = cell.value * tissue.spacing_m;
    tissue.damping_per_s = 100;
    tissue.initial_displacement_m = shaken(tissue, amplitude_m_);
    tissue.substeps = 0;
    scene.body = std::move(tissue);
    scene.tool_count = 0;
    scene.needs_energy = true;
    scene.step_rate = {1000, 1};
    steps = cell.spec.most_steps;
  }
  bool observe(std::int64_t n, const ToolResponse&, Solver& solver) override {
    energy_J_ = solver.verdict().energy_J;
    if (n == 1) first_J_ = energy_J_;
    return energy_J_ <= kRunAway * first_J_ && largest(solver.particle_state().displacement_m) < INFINITY;
  }
  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["energy_left"] = cell.metrics["energy_left_min"] = energy_J_ / first_J_;
  }

 private:
  double amplitude_m_ = 0, energy_J_ = 0, first_J_ = 0;
};

/// S12: a block that stands on a hand, at rest. Whatever its springs do, they must carry the weight of all particles that
/// the hand does not hold. A loop has a shortest step, so a stiffness that needs a shorter one is refused.
class StandingTrial final : public Trial {
 public:
  explicit StandingTrial(const CellSpec& cell) {
    const auto edge = static_cast<int>(cell.spec.particles);
    TissueScene tissue = block(cell, edge);
    tissue.spacing_m = 1.0 / 128;
    tissue.particle_mass_kg = 1e-3;
    tissue.stiffness_N_per_m = cell.value;
    tissue.gravity_m_per_s2 = {0, 0, -kGravity_m_per_s2};
    tissue.fixed = FixedFaces::none();
    tissue.tools = {sole(edge, tissue.spacing_m)};
    weight_N_ = edge * edge * (edge - 1) * tissue.particle_mass_kg * kGravity_m_per_s2;
    // As for the chain: a step of half the limit for every configuration, the slowest sway about critically damped, and
    // forty times its time constant to come to rest (and enough steps for implicit midpoint, which damps motions that it
    // does not resolve only a little).
    const double w_per_s = std::sqrt(cell.value / tissue.particle_mass_kg);
    const double slowest = std::sin(std::numbers::pi / (4 * edge - 2)) * w_per_s;
    tissue.damping_per_s = 2 * slowest;
    scene.step_rate = {std::min<std::int64_t>(static_cast<std::int64_t>(std::ceil(std::sqrt(24.0) * w_per_s)), kFastest_Hz),
                       1};
    scene.tool_count = 1;
    steps = std::max<std::int64_t>(1000, static_cast<std::int64_t>(40 / slowest / period_s(scene.step_rate)));
    observe_every = steps;
    tolerance_ = cell.is_float() ? 1e-2 : 1e-6;
    scene.body = std::move(tissue);
  }
  bool observe(std::int64_t, const ToolResponse& response, Solver&) override {
    error_ = glm::length(response.force_N[0] / weight_N_ - glm::dvec3(0, 0, -1));
    return std::isfinite(error_);
  }
  void judge(Solver&, CaseCell& cell) override {
    cell.metrics["reaction_error"] = error_;
    if (error_ <= tolerance_) return;
    cell.status = CellStatus::drifting;
    cell.shown = error_;
  }

 private:
  /// Holds the bottom layer: a sphere that is wide enough to contain all of it, but nothing of the next layer.
  static ToolCoupling sole(int edge, double spacing_m) {
    const double half = (edge - 1) / 2.0, below = 4 * half * half;
    return {glm::dvec3(half, half, -below) * spacing_m, (std::sqrt(below * below + 2 * half * half) + 0.1) * spacing_m};
  }

  static constexpr double kGravity_m_per_s2 = 9.81;
  static constexpr std::int64_t kFastest_Hz = 10'000;
  double weight_N_ = 1, error_ = 0, tolerance_ = 0;
};

}  // namespace

std::vector<glm::dvec3> shaken(const TissueScene& scene, double amplitude_m) {
  std::vector<glm::dvec3> moved_m(static_cast<std::size_t>(scene.particle_count));
  const auto layer = static_cast<std::size_t>(scene.lattice[0] * scene.lattice[1]);
  std::uint64_t state = 1;
  const auto draw = [&] {
    state = state * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state >> 11) * 0x1p-52 - 1;
  };
  for (std::size_t site = scene.fixed.z_min ? layer : 0; site < moved_m.size(); ++site) {
    const double x = draw(), y = draw(), z = draw();
    moved_m[site] = glm::dvec3(x, y, z) * amplitude_m;
  }
  return moved_m;
}

double rest_lambda_per_s2(const TissueScene& scene, const std::atomic<bool>* interrupted) {
  std::vector<glm::dvec3> x = shaken(scene, 1), y(x.size());
  double lambda = 0;
  constexpr int kRounds = 3000;
  for (int round = 0; round < kRounds && !(interrupted && interrupted->load()); ++round) {
    apply_rest_stiffness(scene, x, y);
    double xy = 0, xx = 0, yy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      xx += glm::dot(x[i], x[i]);
      xy += glm::dot(x[i], y[i]);
      yy += glm::dot(y[i], y[i]);
    }
    lambda = xy / xx;
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = y[i] / std::sqrt(yy);
  }
  return lambda;
}

std::unique_ptr<Trial> make_stability_edge(const CellSpec& cell) { return std::make_unique<EdgeTrial>(cell); }
std::unique_ptr<Trial> make_stiff_in_soft(const CellSpec& cell) { return std::make_unique<StiffInSoftTrial>(cell); }
std::unique_ptr<Trial> make_standing_block(const CellSpec& cell) { return std::make_unique<StandingTrial>(cell); }
std::unique_ptr<Trial> make_energy(const CellSpec& cell) { return std::make_unique<EnergyTrial>(cell); }
std::unique_ptr<Trial> make_crushed(const CellSpec& cell) { return std::make_unique<CrushedTrial>(cell); }

/// Computes the order in which the swing of the energy depends on the step, between neighbouring cells.
void compare_energies(std::span<CaseCell> cells) {
  for (std::size_t c = 1; c < cells.size(); ++c) {
    const auto &fine = cells[c - 1].metrics, &coarse = cells[c].metrics;
    if (!fine.contains("energy_swing") || !coarse.contains("energy_swing")) continue;
    const double order =
        std::log(coarse.at("energy_swing") / fine.at("energy_swing")) / std::log(cells[c].value / cells[c - 1].value);
    cells[c].metrics["order"] = cells[c].metrics["order_min"] = order;
  }
}

}  // namespace evenstep::internal
