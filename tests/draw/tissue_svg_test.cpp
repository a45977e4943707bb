#include "evenstep/draw/tissue_svg.h"

#include "catch.h"
#include "drawn_scenes.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

const SvgPicture kPicture{1600, 1200, "a block", glm::dvec3(0)};

}  // namespace

TEST_CASE("An SVG shows the three sides of a block that are turned to the eye, and no others") {
  const TissueScene tissue = block({4, 4, 4});
  const std::string svg = tissue_svg(TissueMesh(tissue, 0).mesh(), view_of(tissue, 1600, 1200), kPicture);
  CHECK(count(svg, "<path") == 3 * 9);
}

TEST_CASE("What is near is painted after what is far") {
  const TissueScene tissue = block({2, 2, 2});
  const View view = view_of(tissue, 1600, 1200);
  Mesh mesh = TissueMesh(tissue, 0).mesh();
  mesh.colours.assign(mesh.colours.size(), glm::vec3(1, 0, 0));
  const auto vertices = static_cast<std::uint32_t>(mesh.positions_m.size());
  Mesh near = mesh;
  for (glm::vec3& position_m : near.positions_m) position_m += glm::vec3(0.02 * view.to_eye);
  near.colours.assign(near.colours.size(), glm::vec3(0, 0, 1));
  // The nearer mesh comes first, so the right order can come only from depth.
  Mesh both = near;
  both.positions_m.insert(both.positions_m.end(), mesh.positions_m.begin(), mesh.positions_m.end());
  both.colours.insert(both.colours.end(), mesh.colours.begin(), mesh.colours.end());
  for (const auto& [a, b, c, d] : mesh.faces) both.faces.push_back({a + vertices, b + vertices, c + vertices, d + vertices});
  const std::string svg = tissue_svg(both, view, kPicture);
  std::size_t last_red = 0, first_blue = std::string::npos;
  for (std::size_t at = svg.find("fill=\"#", svg.find("<g")); at != std::string::npos; at = svg.find("fill=\"#", at + 1)) {
    const bool blue = svg.substr(at + 7, 2) == "00";
    if (blue)
      first_blue = std::min(first_blue, at);
    else
      last_red = at;
  }
  CHECK(last_red < first_blue);
}

TEST_CASE("An arrow that the block hides is dashed over it") {
  const TissueScene tissue = block({4, 4, 4});
  Mesh mesh = TissueMesh(tissue, 0).mesh();
  mesh.arrows_m = {{glm::dvec3(0), glm::dvec3(0.001)}};
  const View view = view_of(tissue, 1600, 1200);
  const std::string svg = tissue_svg(mesh, view, kPicture);
  const std::size_t last_face = svg.rfind("</g>");
  CHECK(count(svg, "stroke-dasharray=\"14 9\"") == 1);
  CHECK(svg.find("stroke-dasharray=\"14 9\"") > last_face);
}

TEST_CASE("A title is text, whatever it says, and a position that is far away stays a number") {
  const TissueScene tissue = block({3, 3, 3});
  Mesh mesh = TissueMesh(tissue, 0).mesh();
  mesh.positions_m[0] = glm::vec3(1e30F, -1e30F, 0);
  const std::string svg = tissue_svg(mesh, view_of(tissue, 800, 600), {800, 600, "<script>&", 0.005 * glm::dvec3(2, 2, 2)});
  CHECK_THAT(svg, Contains("&lt;script&gt;&amp;"));
  CHECK_THAT(svg, !Contains("nan") && !Contains("inf") && Contains("stroke-dasharray"));
  CHECK(count(svg, "<svg") == 1);
}
