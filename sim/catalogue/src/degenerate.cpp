#include "degenerate.h"

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace evenstep::internal {
namespace {

enum What {
  alone = 1,
  all_fixed,
  coincident,
  collapsed,
  unattached,
  denormal,
  jump,
  no_mass,
  no_particle,
  no_stiffness,
  nan_hand,
  infinite_hand
};

/// It is only required that the run stays finite and bounded.
class DegenerateTrial final : public Trial {
 public:
  explicit DegenerateTrial(const CellSpec& cell) : what_(static_cast<int>(cell.value)) {
    TissueScene tissue;
    tissue.method = cell.method;
    tissue.iterations = cell.spec.iterations;
    tissue.damping_per_s = 100;
    tissue.lattice = {5, 5, 5};
    scene.step_rate = {1000, 1};
    scene.tool_count = 0;
    steps = 200;
    shape(tissue);
    scene.body = std::move(tissue);
  }
  void hands(std::int64_t n, std::span<glm::dvec3> positions_m) const override {
    if (positions_m.empty()) return;
    positions_m[0] = glm::dvec3(0);
    if (what_ == jump && n >= 100) positions_m[0].x = 1e-2;  // 10 m/s for one step
    if (n < 100) return;
    if (what_ == nan_hand) positions_m[0].x = std::numeric_limits<double>::quiet_NaN();
    if (what_ == infinite_hand) positions_m[0].x = std::numeric_limits<double>::infinity();
  }
  bool observe(std::int64_t, const ToolResponse& response, Solver& solver) override {
    const ParticleState state = solver.particle_state();
    for (std::size_t i = 0; i < state.displacement_m.size(); ++i) {
      const glm::dvec3 &u = state.displacement_m[i], &v = state.velocity_m_per_s[i];
      if (!(glm::length(u) <= 1) || !(glm::length(v) <= 1e3)) return false;
    }
    return std::isfinite(glm::length(response.force_N[0]));
  }
  void judge(Solver&, CaseCell&) override {}

 private:
  void shape(TissueScene& tissue) {
    if (what_ == alone || what_ == all_fixed) tissue.lattice = {1, 1, 1};
    if (what_ == alone) tissue.fixed = FixedFaces::none();
    tissue.particle_count = std::int64_t{tissue.lattice[0]} * tissue.lattice[1] * tissue.lattice[2];
    const auto count = static_cast<std::size_t>(tissue.particle_count);
    const double spacing_m = tissue.spacing_m;
    if (what_ == coincident || what_ == denormal) tissue.initial_displacement_m.resize(count);
    if (what_ == coincident) tissue.initial_displacement_m[62].x = spacing_m;  // where its neighbour is
    if (what_ == denormal)
      for (glm::dvec3& u : tissue.initial_displacement_m) u = glm::dvec3(1e-310, -1e-42, 1e-44);
    if (what_ == collapsed) {
      for (std::size_t i = 0; i < count; ++i)
        tissue.initial_displacement_m.push_back(-spacing_m * glm::dvec3(i % 5, i / 5 % 5, i / 25));
      tissue.fixed = FixedFaces::none();
    }
    // The last layer is cut to one particle on a lattice of columns, so its only springs are those to the layer below.
    if (what_ == unattached) tissue.lattice = {1, 1, 2}, tissue.particle_count = 1, tissue.fixed = FixedFaces::none();
    if (what_ == no_mass) tissue.particle_mass_kg = 0;
    if (what_ == no_particle) tissue.particle_count = 0;
    if (what_ == no_stiffness) tissue.stiffness_N_per_m = 0;
    if (what_ == jump || what_ == nan_hand || what_ == infinite_hand) {
      tissue.tools = {{{2 * spacing_m, 2 * spacing_m, 4 * spacing_m}, 1.1 * spacing_m}};
      scene.tool_count = 1;
    }
  }

  int what_;
};

}  // namespace

std::unique_ptr<Trial> make_degenerate(const CellSpec& cell) { return std::make_unique<DegenerateTrial>(cell); }

}  // namespace evenstep::internal
