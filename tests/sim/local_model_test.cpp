// ToolResponse::contact, against differences of forces.
#include <catch2/catch.hpp>

#include "feature_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::array kKinds{CouplingKind::grab, CouplingKind::spring, CouplingKind::probe};

Scene modelled(TissueScene tissue, LocalModel model, double step_s) {
  Scene scene = scene_of(std::move(tissue), step_s);
  scene.local_model = model;
  return scene;
}

bool same_contact(const ToolContact& a, const ToolContact& b) {
  return a.touching == b.touching && std::memcmp(&a.point_m, &b.point_m, sizeof a.point_m) == 0 && same_bits(a.gap_m, b.gap_m) &&
         std::memcmp(&a.stiffness_N_per_m, &b.stiffness_N_per_m, sizeof a.stiffness_N_per_m) == 0;
}

double largest(const glm::dmat3& m) {
  double most = 0;
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) most = std::max(most, std::abs(m[c][r]));
  return most;
}

}  // namespace

TEST_CASE("The instantaneous model is the change of force with particles too heavy to follow", "[local]") {
  for (const CouplingKind kind : kKinds) {
    TissueScene block = featured_block({true, false, false, false, kind});
    for (MaterialRegion& region : block.regions) region.particle_mass_kg = 1e6;
    block.particle_mass_kg = 1e6;
    block.substeps = 1;
    block.tools[0].damping_N_s_per_m = block.tools[1].damping_N_s_per_m = 0;
    const auto solver = make_solver(SolverKind::cpu_double, modelled(block, LocalModel::instantaneous, 1e-3));
    Positions at{};
    step(*solver, 2, at);
    at = {glm::dvec3(1e-3, 2e-3, -1e-3), glm::dvec3(0, -1e-3, -2e-3)};
    const ToolResponse here = step(*solver, 2, at);
    for (std::size_t tool = 0; tool < 2; ++tool) {
      const glm::dmat3& k = here.contact[tool].stiffness_N_per_m;
      REQUIRE(here.contact[tool].touching);
      REQUIRE(largest(k) > 10);
      for (int axis = 0; axis < 3; ++axis) {
        Positions above = at, below = at;
        above[tool][axis] += 1e-7;
        below[tool][axis] -= 1e-7;
        const glm::dvec3 change = step(*solver, 2, above).force_N[tool] - step(*solver, 2, below).force_N[tool];
        for (int row = 0; row < 3; ++row) {
          CHECK(-change[row] / 2e-7 == Approx(k[axis][row]).margin(1e-5 * largest(k)));
          CHECK(k[axis][row] == k[row][axis]);
        }
      }
    }
  }
}

TEST_CASE("The settled model is the change of force once the particles have come to rest again", "[local]") {
  for (const CouplingKind kind : {CouplingKind::grab, CouplingKind::spring}) {
    TissueScene block = featured_block({true, true, false, false, kind});
    block.damping_per_s = 150;
    block.tools.pop_back();
    const auto solver = make_solver(SolverKind::cpu_double, modelled(block, LocalModel::settled, 1e-3));
    const glm::dmat3 k = step(*solver, 1, {}).contact[0].stiffness_N_per_m;
    CHECK(largest(k) > 10);
    for (int axis = 0; axis < 3; ++axis) {
      std::array<glm::dvec3, 2> force_N{};
      for (int side = 0; side < 2; ++side) {
        Positions at{};
        at[0][axis] = side == 0 ? 1e-6 : -1e-6;
        for (int n = 0; n < 1500; ++n) force_N[static_cast<std::size_t>(side)] = step(*solver, 1, at).force_N[0];
      }
      for (int row = 0; row < 3; ++row)
        CHECK(-(force_N[0][row] - force_N[1][row]) / 2e-6 == Approx(k[axis][row]).margin(1e-4 * largest(k)));
    }
  }
}

TEST_CASE("A coupling in series with a spring has the settled stiffness k kc / (k + kc); a free particle none", "[local]") {
  TissueScene tissue;
  tissue.lattice = {1, 1, 2};
  tissue.particle_count = 2;
  tissue.stiffness_N_per_m = 40;
  tissue.tools = {{glm::dvec3(0, 0, 5e-3), 1e-3, CouplingKind::spring, 25}};
  const auto settled = [&] {
    return step(*make_solver(SolverKind::cpu_double, modelled(tissue, LocalModel::settled, 1e-3)), 1, {}).contact[0].stiffness_N_per_m;
  };
  const glm::dmat3 on_spring = settled();
  CHECK(on_spring[2][2] == Approx(40.0 * 25 / (40 + 25)));
  CHECK(std::abs(on_spring[0][0]) < 1e-12);  // a spring on a line gives way to the side
  tissue.fixed = FixedFaces::none();
  CHECK(largest(settled()) < 1e-9);
}

TEST_CASE("Local models are equal on cpu float and OpenCL, bit for bit", "[local][equality]") {
  for (const LocalModel model : {LocalModel::instantaneous, LocalModel::settled}) {
    for (const CouplingKind kind : kKinds) {
      if (model == LocalModel::settled && kind != CouplingKind::grab) continue;  // a number from the host
      const Scene scene = modelled(featured_block({true, true, true, true, kind}), model, 1e-3);
      const auto cpu = make_solver(SolverKind::cpu_float, scene), opencl = make_solver(SolverKind::opencl, scene);
      for (int n = 0; n < 60; ++n) {
        const ToolResponse a = step(*cpu, 2, wandering_tools(3 * n)), b = step(*opencl, 2, wandering_tools(3 * n));
        for (std::size_t tool = 0; tool < 2; ++tool) {
          REQUIRE(same_contact(a.contact[tool], b.contact[tool]));
          const bool is_probe = two_tools(kind, 1)[tool].kind == CouplingKind::probe;
          REQUIRE((a.contact[tool].gap_m < 0) == (is_probe && a.contact[tool].touching));
        }
      }
    }
  }
}
