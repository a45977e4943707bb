// What is drawn of a tissue, without OpenGL.
#include "evenstep/draw/tissue_mesh.h"

#include <glm/geometric.hpp>

#include "catch.h"
#include "drawn_scenes.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("The surface of a block has the sides of its outer cubes, and a corner of it is one vertex") {
  const int n = GENERATE(2, 3, 7);
  const TissueScene tissue = block({n, n, n});
  const TissueMesh drawn(tissue, 0);
  const auto sides = static_cast<std::size_t>(6 * (n - 1) * (n - 1));
  CHECK(drawn.mesh().faces.size() == sides);
  CHECK(drawn.mesh().positions_m.size() == sides + 2);  // Euler: V - E + F = 2, and E = 2 F
}

TEST_CASE("All faces look outwards") {
  const TissueScene tissue = with_tool(block({4, 5, 6}), CouplingKind::probe);
  TissueMesh drawn(tissue, 0.01);
  drawn.move(at_rest(tissue), std::vector<DrawnTool>{{glm::dvec3(0), {0, 0, 2}}});
  const Mesh& mesh = drawn.mesh();
  const std::size_t of_tissue = 2 * (3 * 4 + 3 * 5 + 4 * 5), of_sphere = 512;
  REQUIRE(mesh.faces.size() == of_tissue + of_sphere + 10);
  const glm::dvec3 middle = 0.5 * tissue.spacing_m * glm::dvec3(3, 4, 5);
  for (std::size_t n = 0; n < of_tissue + of_sphere; ++n) {
    const auto at = [&](std::size_t corner) { return glm::dvec3(mesh.positions_m[mesh.faces[n][corner]]); };
    const glm::dvec3 normal = glm::cross(at(1) - at(0), at(2) - at(0));
    REQUIRE(glm::dot(normal, at(0) - (n < of_tissue ? middle : tissue.tools[0].center_m)) > 0);
  }
}

TEST_CASE("A particle that belongs to no whole cube is drawn by itself") {
  const TissueMesh chain(block({5, 1, 1}), 0), sheet(block({3, 3, 1}), 0);
  CHECK(chain.mesh().faces.size() == 5 * 8);
  CHECK(sheet.mesh().faces.size() == 9 * 8);
  TissueScene cut = block({3, 3, 3});
  cut.particle_count = 18 + 1;  // two layers and one particle
  CHECK(TissueMesh(cut, 0).mesh().faces.size() == (2 * 4 + 4 * 2) + 8);
}

TEST_CASE("The vertices move with the particles, and what is not finite stays where it rests") {
  const TissueScene tissue = block({3, 3, 3});
  TissueMesh drawn(tissue, 0);
  const std::vector<glm::vec3> rest = drawn.mesh().positions_m;
  ParticleState state = at_rest(tissue);
  for (glm::dvec3& moved : state.displacement_m) moved = {0.001, 0, -0.002};
  const double bad = GENERATE(std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN(), 1e300);
  state.displacement_m[0].y = bad;
  drawn.move(state, {});
  std::size_t stayed = 0;
  for (std::size_t n = 0; n < rest.size(); ++n) {
    const glm::vec3 moved = drawn.mesh().positions_m[n] - rest[n];
    stayed += moved == glm::vec3(0);
    if (moved != glm::vec3(0)) CHECK(glm::length(moved - glm::vec3(0.001F, 0, -0.002F)) < 1e-7F);
  }
  CHECK(stayed == 1);
}

TEST_CASE("What a grab holds has the tool's colour, and what is fixed is grey") {
  const TissueScene tissue = with_tool(block({5, 5, 5}), CouplingKind::grab);
  const TissueMesh drawn(tissue, 0);
  std::set<std::tuple<float, float, float>> colours;
  for (std::size_t n = 0; n < 98; ++n)
    colours.insert({drawn.mesh().colours[n].r, drawn.mesh().colours[n].g, drawn.mesh().colours[n].b});
  CHECK(colours.size() == 3);
}

TEST_CASE("Each face of the block that is fixed is grey, and none that is not") {
  const int n = 4;
  TissueScene loose = block({n, n, n});
  loose.fixed = FixedFaces::none();
  const glm::vec3 tissue_colour = TissueMesh(loose, 0).mesh().colours.front();
  for (int axis = 0; axis < 3; ++axis) {
    for (const bool far : {false, true}) {
      TissueScene tissue = loose;
      FixedFaces& fixed = tissue.fixed;
      (far         ? axis == 0   ? fixed.x_max
                     : axis == 1 ? fixed.y_max
                                 : fixed.z_max
       : axis == 0 ? fixed.x_min
       : axis == 1 ? fixed.y_min
                   : fixed.z_min) = true;
      const TissueMesh drawn(tissue, 0);
      const Mesh& mesh = drawn.mesh();
      int grey = 0;
      for (std::size_t at = 0; at < mesh.positions_m.size(); ++at) {
        const float end = far ? static_cast<float>(tissue.spacing_m * (n - 1)) : 0;
        const bool on_face = std::abs(mesh.positions_m[at][axis] - end) < 1e-6F;
        grey += mesh.colours[at] != tissue_colour;
        CHECK((mesh.colours[at] != tissue_colour) == on_face);
      }
      CHECK(grey == n * n);
    }
  }
}

TEST_CASE("An arrow is as long as the force is large, points along it, and is never longer than the block") {
  const TissueScene tissue = with_tool(block({5, 5, 5}), CouplingKind::probe);
  TissueMesh drawn(tissue, 0.01);
  const auto tip = [&](const glm::dvec3& force_N) {
    drawn.move(at_rest(tissue), std::vector<DrawnTool>{{{0.001, 0, 0}, force_N}});
    return glm::dvec3(drawn.mesh().positions_m.back()) - tissue.tools[0].center_m - glm::dvec3(0.001, 0, 0);
  };
  CHECK(glm::length(tip({0, 0.5, 0}) - glm::dvec3(0, 0.005, 0)) < 1e-7);
  CHECK(glm::length(tip({0, 0, -1}) - glm::dvec3(0, 0, -0.01)) < 1e-7);
  CHECK(glm::length(tip({1e300, 0, 0})) < 1e-7);  // its length is not finite
  CHECK(glm::length(tip({-1e9, 0, 0}) - glm::dvec3(-block_size_m(tissue), 0, 0)) < 1e-7);
  CHECK(glm::length(tip({0, 0, 0})) < 1e-7);
}
