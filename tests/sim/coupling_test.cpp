// The stiffness of tools in three dimensions, and how the tissue couples two of them.
#include <algorithm>

#include "catch.h"
#include "feature_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

using Six = std::array<std::array<double, 6>, 6>;

/// nx x ny x nz sites, 8 mm apart, held at the bottom, with two lumps in the top layer.
TissueScene held_block(std::array<int, 3> lattice, const glm::dvec3& first, const glm::dvec3& second,
                       CouplingKind kind = CouplingKind::grab) {
  TissueScene block;
  block.lattice = lattice;
  block.particle_count = static_cast<std::int64_t>(lattice[0]) * lattice[1] * lattice[2];
  block.spacing_m = 8e-3;
  block.particle_mass_kg = 5.12e-4;
  block.damping_per_s = 150;
  block.stiffness_N_per_m = 20;
  const double radius_m = 0.9 * block.spacing_m;
  block.tools = {{first * 8e-3, radius_m, CouplingKind::grab},
                 {second * 8e-3, radius_m, kind, kind == CouplingKind::spring ? 60.0 : 0.0}};
  return block;
}

Scene coupled(const TissueScene& block, LocalModel model) {
  Scene scene = scene_of(block, 1e-3);
  scene.local_model = model;
  scene.local_coupling = true;
  return scene;
}

/// [K C; C' K'] of the two tools at their present places.
Six joint(const Solver& solver) {
  Six k{};
  for (std::size_t t = 0; t < 2; ++t) {
    const ToolContact& contact = solver.contacts()[t];
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        const auto r = 3 * t + static_cast<std::size_t>(row), c = static_cast<std::size_t>(column);
        k[r][3 * t + c] = contact.stiffness_N_per_m[column][row];
        k[r][3 * (1 - t) + c] = contact.coupling_N_per_m[column][row];
      }
    }
  }
  return k;
}

double largest_of(const Six& k) {
  double most = 0;
  for (const auto& row : k)
    for (const double value : row) most = std::max(most, std::abs(value));
  return most;
}

/// The smallest pivot of Gauss's elimination without exchanges: not negative for a positive semidefinite matrix.
double least_pivot(Six k) {
  double least = k[0][0];
  for (std::size_t p = 0; p < 6; ++p) {
    least = std::min(least, k[p][p]);
    if (k[p][p] <= 0) continue;
    for (std::size_t r = p + 1; r < 6; ++r) {
      const double share = k[r][p] / k[p][p];
      for (std::size_t c = 0; c < 6; ++c) k[r][c] -= share * k[p][c];
    }
  }
  return least;
}

std::unique_ptr<Solver> started(const Scene& scene) {
  auto solver = make_solver(SolverKind::cpu_double, scene);
  step(*solver, 2, {});
  return solver;
}

}  // namespace

TEST_CASE("The settled coupling is how a force has changed once the particles rest again under the other tool",
          "[local][sweep]") {
  for (const CouplingKind kind : {CouplingKind::grab, CouplingKind::spring}) {
    const auto solver = started(coupled(held_block({5, 3, 4}, {1, 1, 3}, {3, 1, 3}, kind), LocalModel::settled));
    const Six k = joint(*solver);
    const double size = largest_of(k);
    for (std::size_t column = 0; column < 6; ++column) {
      std::array<ToolResponse, 2> felt;
      for (int side = 0; side < 2; ++side) {
        Positions at{};
        at[column / 3][static_cast<int>(column % 3)] = side == 0 ? 1e-6 : -1e-6;
        for (int n = 0; n < 1500; ++n) felt[static_cast<std::size_t>(side)] = step(*solver, 2, at);
      }
      for (std::size_t row = 0; row < 6; ++row) {
        const int axis = static_cast<int>(row % 3);
        const double change = felt[0].force_N[row / 3][axis] - felt[1].force_N[row / 3][axis];
        CHECK(-change / 2e-6 == Approx(k[row][column]).margin(1e-4 * size));
      }
    }
    CHECK(std::abs(k[0][3]) > 0.02 * size);  // the tools are really coupled: they are two spacings apart
  }
}

TEST_CASE("The instantaneous coupling is what goes from lump to lump in springs, and nothing between lumps apart",
          "[local]") {
  TissueScene block = held_block({5, 3, 4}, {1, 1, 3}, {2, 1, 3});
  block.particle_mass_kg = 1e6;
  block.damping_per_s = 0;
  block.substeps = 1;
  block.tools[0].radius_m = block.tools[1].radius_m = 0.6 * block.spacing_m;
  const auto solver = started(coupled(block, LocalModel::instantaneous));
  Positions at{glm::dvec3(1e-3, 2e-3, -1e-3), glm::dvec3(0, -1e-3, -2e-3)};
  step(*solver, 2, at);
  const Six k = joint(*solver);
  for (std::size_t column = 0; column < 6; ++column) {
    Positions above = at, below = at;
    above[column / 3][static_cast<int>(column % 3)] += 1e-7;
    below[column / 3][static_cast<int>(column % 3)] -= 1e-7;
    const ToolResponse up = step(*solver, 2, above), down = step(*solver, 2, below);
    for (std::size_t row = 0; row < 6; ++row) {
      const int axis = static_cast<int>(row % 3);
      CHECK(-(up.force_N[row / 3][axis] - down.force_N[row / 3][axis]) / 2e-7 ==
            Approx(k[row][column]).margin(1e-5 * largest_of(k)));
    }
  }
  CHECK(std::abs(k[0][3]) > 10);
  const auto apart = started(coupled(held_block({5, 3, 4}, {0, 1, 3}, {4, 1, 3}), LocalModel::instantaneous));
  CHECK(apart->contacts()[0].coupling_N_per_m == glm::dmat3(0));
}

TEST_CASE("Stiffness and coupling of two tools are one symmetric positive semidefinite matrix, 60 pairs of lumps",
          "[local]") {
  int compared = 0;
  for (const LocalModel model : {LocalModel::settled, LocalModel::instantaneous}) {
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 5; ++j) {
        const glm::dvec3 first(i % 3, i / 3, 3 - j % 2), second(4 + j % 2, (i + j) % 4, 3);
        const auto solver = started(coupled(held_block({6, 4, 4}, first, second), model));
        const Six k = joint(*solver);
        const double size = largest_of(k);
        REQUIRE(size > 10);
        // Conjugate gradients stop at 1e-9. Between the two blocks, K is symmetric by construction.
        for (std::size_t r = 0; r < 6; ++r)
          for (std::size_t c = 0; c < r; ++c) REQUIRE(std::abs(k[r][c] - k[c][r]) <= 1e-7 * size);
        REQUIRE(least_pivot(k) >= -1e-7 * size);
        ++compared;
      }
    }
  }
  CHECK(compared == 60);
}

TEST_CASE("A block that is turned onto its side has its stiffness and coupling turned with it, all six turns of its axes",
          "[local]") {
  const std::array<std::array<int, 3>, 6> orders{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  for (const LocalModel model : {LocalModel::settled, LocalModel::instantaneous}) {
    Six upright{};
    for (const auto& to : orders) {
      const auto turned = [&](const glm::dvec3& v) {
        glm::dvec3 out{0};
        for (int axis = 0; axis < 3; ++axis) out[to[static_cast<std::size_t>(axis)]] = v[axis];
        return out;
      };
      const std::array<int, 3> size{5, 4, 4};
      std::array<int, 3> lattice{};
      for (std::size_t axis = 0; axis < 3; ++axis) lattice[static_cast<std::size_t>(to[axis])] = size[axis];
      TissueScene block = held_block(lattice, turned(glm::dvec3(0, 0, 3)), turned(glm::dvec3(2, 1, 3)));
      block.fixed = FixedFaces::none();
      bool* const low[3] = {&block.fixed.x_min, &block.fixed.y_min, &block.fixed.z_min};
      *low[to[2]] = true;
      const Six k = joint(*started(coupled(block, model)));
      if (to == orders[0]) upright = k;
      const double largest = largest_of(upright);
      REQUIRE(std::abs(upright[0][2]) > 1e-3 * largest);  // at a corner a push to the side meets a force upwards
      for (std::size_t r = 0; r < 6; ++r) {
        for (std::size_t c = 0; c < 6; ++c) {
          const auto tr = r / 3 * 3 + static_cast<std::size_t>(to[r % 3]),
                     tc = c / 3 * 3 + static_cast<std::size_t>(to[c % 3]);
          REQUIRE(std::abs(k[tr][tc] - upright[r][c]) <= 1e-7 * largest);
        }
      }
    }
  }
}

TEST_CASE("The coupling fades with the distance of the two hands, and a probe has none", "[local]") {
  double before = 1;
  for (const int apart : {2, 4, 6, 8}) {
    const Six k =
        joint(*started(coupled(held_block({11, 3, 4}, {1, 1, 3}, glm::dvec3(1 + apart, 1, 3)), LocalModel::settled)));
    double most = 0;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t c = 3; c < 6; ++c) most = std::max(most, std::abs(k[r][c]));
    const double share = most / largest_of(k);
    INFO(apart << " spacings: " << share);
    CHECK(share < 0.8 * before);
    before = share;
  }
  CHECK(before < 0.1);
  TissueScene block = held_block({6, 4, 4}, {1, 1, 3}, {4, 1, 3});
  block.tools[1] = {glm::dvec3(32e-3, 8e-3, 40e-3), 18e-3, CouplingKind::probe, 35};
  for (const LocalModel model : {LocalModel::settled, LocalModel::instantaneous}) {
    const auto solver = started(coupled(block, model));
    REQUIRE(solver->contacts()[1].touching);
    for (const ToolContact& contact : solver->contacts()) CHECK(contact.coupling_N_per_m == glm::dmat3(0));
  }
}
