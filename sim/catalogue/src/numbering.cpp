#include "evenstep/catalogue/numbering.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

#include "blocks.h"

namespace evenstep::internal {
namespace {

/// The largest distance between corresponding vectors.
double difference(const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double apart = glm::length(a[i] - b[i]);
    if (!std::isfinite(apart)) return INFINITY;
    most = std::max(most, apart);
  }
  return most;
}

/// A position in the block in the new axes.
glm::dvec3 position(const Numbering& numbering, const TissueScene& old, const glm::dvec3& old_m) {
  glm::dvec3 new_m;
  for (int a = 0; a < 3; ++a) {
    const int from = numbering.from[static_cast<std::size_t>(a)];
    const double end_m = old.spacing_m * (old.lattice[static_cast<std::size_t>(from)] - 1);
    new_m[a] = numbering.mirrored[static_cast<std::size_t>(a)] ? end_m - old_m[from] : old_m[from];
  }
  return new_m;
}

std::vector<glm::dvec3> renumbered(const Numbering& numbering, const TissueScene& old,
                                   const std::vector<glm::dvec3>& vectors) {
  std::vector<glm::dvec3> out(vectors.size());
  for (std::size_t site = 0; site < vectors.size(); ++site) out[numbering.site(old, site)] = numbering.vector(vectors[site]);
  return out;
}

FixedFaces faces(const Numbering& numbering, const FixedFaces& old) {
  const std::array<std::array<bool, 2>, 3> ends{{{old.x_min, old.x_max}, {old.y_min, old.y_max}, {old.z_min, old.z_max}}};
  std::array<std::array<bool, 2>, 3> out;
  for (std::size_t a = 0; a < 3; ++a) {
    out[a] = ends[static_cast<std::size_t>(numbering.from[a])];
    if (numbering.mirrored[a]) std::swap(out[a][0], out[a][1]);
  }
  return {out[0][0], out[0][1], out[1][0], out[1][1], out[2][0], out[2][1]};
}

/// A block with three different edges and everything that enters a sum: two materials, both dampers, weight, a hand that
/// holds particles and a sphere that pushes. Every position is a multiple of a power of two, so mirroring is exact.
class NumberingTrial final : public Trial {
 public:
  explicit NumberingTrial(const CellSpec& cell) : solver_(cell.solver) {
    TissueScene tissue;
    tissue.lattice = {4, 5, 6};
    tissue.particle_count = 120;
    tissue.spacing_m = kSpacing_m;
    tissue.fixed.x_min = true;
    tissue.damping_per_s = 100;
    tissue.axial_damping_N_s_per_m = 1e-3;
    tissue.gravity_m_per_s2 = {1, -2, -9.81};
    tissue.regions = {
        {glm::dvec3(0), glm::dvec3(1.5, 2.5, 2.5) * kSpacing_m, 2 * tissue.stiffness_N_per_m, 2 * tissue.particle_mass_kg}};
    tissue.tools = {{glm::dvec3(1, 1, 5) * kSpacing_m, 0.75 * kSpacing_m},
                    {glm::dvec3(3, 4, 7) * kSpacing_m, 1.75 * kSpacing_m, CouplingKind::probe, 100, 0}};
    tissue.method = cell.method;
    tissue.iterations = cell.spec.iterations;
    tissue.initial_displacement_m = shaken(tissue, kSpacing_m / 8);
    scene.body = std::move(tissue);
    scene.tool_count = 2;
    scene.step_rate = {1000, 1};
    steps = static_cast<std::int64_t>(cell.value);
    observe_every = steps;
    tolerance_ = cell.is_float() ? 1e-6 : 1e-14;
  }
  void hands(std::int64_t n, std::span<glm::dvec3> positions_m) const override {
    const double part = static_cast<double>(n) / static_cast<double>(std::max<std::int64_t>(steps, 100));
    positions_m[0] = glm::dvec3(0.5, -0.25, 0.5) * (part * kSpacing_m);
    positions_m[1] = glm::dvec3(-0.25, 0, -0.5) * (part * kSpacing_m);
  }
  bool observe(std::int64_t, const ToolResponse& response, Solver&) override {
    response_ = response;
    return std::isfinite(glm::length(response.force_N[0])) && std::isfinite(glm::length(response.force_N[1]));
  }
  void judge(Solver& solver, CaseCell& cell) override {
    const ParticleState state = solver.particle_state();
    double most = 0;
    for (const Numbering& numbering : all_numberings()) {
      const bool all = std::all_of(numbering.mirrored.begin(), numbering.mirrored.end(), [](bool m) { return m; });
      const bool none = std::none_of(numbering.mirrored.begin(), numbering.mirrored.end(), [](bool m) { return m; });
      if (all || none) most = std::max(most, difference_of(numbering, state));
    }
    cell.metrics["numbering_difference"] = most;
    if (most <= tolerance_) return;
    cell.status = CellStatus::drifting;
    cell.shown = most;
  }

 private:
  double difference_of(const Numbering& numbering, const ParticleState& state) const {
    const auto& tissue = std::get<TissueScene>(scene.body);
    Scene other = scene;
    other.body = numbering.scene(tissue);
    const std::unique_ptr<Solver> solver = make_solver(solver_, other);
    ToolResponse response;
    for (std::int64_t n = 0; n < steps; ++n) {
      std::array<glm::dvec3, kMaxTools> positions_m{};
      hands(n, positions_m);
      for (glm::dvec3& position_m : positions_m) position_m = numbering.vector(position_m);
      response = solver->step(positions_m);
    }
    const ParticleState found = solver->particle_state();
    std::vector<glm::dvec3> expected_N, found_N;
    for (const glm::dvec3& force_N : response_.force_N) expected_N.push_back(numbering.vector(force_N));
    for (const glm::dvec3& force_N : response.force_N) found_N.push_back(force_N);
    const double speed_m_per_s = kSpacing_m * std::sqrt(tissue.stiffness_N_per_m / tissue.particle_mass_kg);
    const auto over = [](double scale, const std::vector<glm::dvec3>& a, const std::vector<glm::dvec3>& b) {
      return difference(a, b) / scale;
    };
    return std::max({over(kSpacing_m, renumbered(numbering, tissue, state.displacement_m), found.displacement_m),
                     over(speed_m_per_s, renumbered(numbering, tissue, state.velocity_m_per_s), found.velocity_m_per_s),
                     over(kSpacing_m * tissue.stiffness_N_per_m, expected_N, found_N)});
  }

  static constexpr double kSpacing_m = 1.0 / 128;
  SolverKind solver_;
  ToolResponse response_;
  double tolerance_ = 0;
};

}  // namespace

glm::dvec3 Numbering::vector(const glm::dvec3& old) const {
  glm::dvec3 out;
  for (int a = 0; a < 3; ++a) {
    const double value = old[from[static_cast<std::size_t>(a)]];
    out[a] = mirrored[static_cast<std::size_t>(a)] ? -value : value;
  }
  return out;
}

std::size_t Numbering::site(const TissueScene& old, std::size_t site) const {
  const auto nx = static_cast<std::size_t>(old.lattice[0]), ny = static_cast<std::size_t>(old.lattice[1]);
  const std::array<std::size_t, 3> at{site % nx, site / nx % ny, site / nx / ny};
  std::size_t out = 0;
  for (const std::size_t a : {2, 1, 0}) {
    const auto axis = static_cast<std::size_t>(from[a]), edge = static_cast<std::size_t>(old.lattice[axis]);
    out = out * edge + (mirrored[a] ? edge - 1 - at[axis] : at[axis]);
  }
  return out;
}

TissueScene Numbering::scene(const TissueScene& old) const {
  assert(old.particle_count == std::int64_t{old.lattice[0]} * old.lattice[1] * old.lattice[2]);
  TissueScene out = old;
  for (std::size_t a = 0; a < 3; ++a) out.lattice[a] = old.lattice[static_cast<std::size_t>(from[a])];
  out.fixed = faces(*this, old.fixed);
  out.gravity_m_per_s2 = vector(old.gravity_m_per_s2);
  for (MaterialRegion& region : out.regions) {
    const glm::dvec3 one_m = position(*this, old, region.min_m), other_m = position(*this, old, region.max_m);
    region.min_m = glm::min(one_m, other_m);
    region.max_m = glm::max(one_m, other_m);
  }
  for (ToolCoupling& tool : out.tools) tool.center_m = position(*this, old, tool.center_m);
  out.initial_displacement_m = renumbered(*this, old, old.initial_displacement_m);
  out.initial_velocity_m_per_s = renumbered(*this, old, old.initial_velocity_m_per_s);
  return out;
}

std::vector<Numbering> all_numberings() {
  std::vector<Numbering> all;
  std::array<int, 3> from{0, 1, 2};
  do {
    for (int bits = 0; bits < 8; ++bits) {
      const bool own = bits == 0 && std::is_sorted(from.begin(), from.end());
      if (!own) all.push_back({from, {(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0}});
    }
  } while (std::next_permutation(from.begin(), from.end()));
  return all;
}

std::unique_ptr<Trial> make_numbering(const CellSpec& cell) { return std::make_unique<NumberingTrial>(cell); }

}  // namespace evenstep::internal
