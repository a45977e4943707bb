// The off-screen renderer. The tests check only facts about pixels that hold for every rasteriser.
#include "evenstep/draw/canvas.h"

#include "catch.h"
#include "drawn_scenes.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

bool maps_opengl() {
  std::ifstream maps("/proc/self/maps");
  const std::string text((std::istreambuf_iterator<char>(maps)), {});
  return text.find("libEGL") != std::string::npos || text.find("libGL") != std::string::npos;
}

/// A canvas for the mesh; null, after a warning, if this machine cannot draw.
std::unique_ptr<Canvas> canvas_for(const TissueScene& tissue, const Mesh& mesh, int width = 320, int height = 240) {
  auto canvas = make_canvas(width, height, view_of(tissue, width, height), mesh);
  if (canvas) return *std::move(canvas);
  WARN("skipped: " << canvas.error().what << "; " << canvas.error().remedy);
  return nullptr;
}

using Pixel = std::array<std::uint8_t, 3>;
Pixel pixel(const Image& image, int x, int y) {
  const std::size_t at = static_cast<std::size_t>(y * image.width + x) * 4;
  return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]};
}
bool is_background(const Pixel& pixel) {
  return std::abs(pixel[0] - 245) <= 1 && std::abs(pixel[1] - 245) <= 1 && std::abs(pixel[2] - 247) <= 1;
}

struct Seen {
  double x = 0, y = 0;  ///< the centre of what is drawn
  std::int64_t pixels = 0;
};
Seen seen(const Image& image) {
  Seen sum;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (is_background(pixel(image, x, y))) continue;
      sum.x += x;
      sum.y += y;
      ++sum.pixels;
    }
  }
  const auto n = static_cast<double>(std::max<std::int64_t>(sum.pixels, 1));
  return {sum.x / n, sum.y / n, sum.pixels};
}

}  // namespace

TEST_CASE("A program loads no OpenGL before it draws") {
  const TissueScene tissue = block({4, 4, 4});
  const TissueMesh mesh(tissue, 0);
  CHECK_FALSE(make_canvas(kMostCanvas + 1, 100, view_of(tissue, 100, 100), mesh.mesh()));
  CHECK_FALSE(maps_opengl());
  if (!canvas_for(tissue, mesh.mesh())) return;
  CHECK(maps_opengl());
}

TEST_CASE("A size out of the limits is an error that says the limits") {
  if (!built_with_drawing()) {
    WARN("skipped: built without OpenGL");
    return;
  }
  const TissueScene tissue = block({2, 2, 2});
  const auto [width, height] = GENERATE(std::pair(0, 100), std::pair(15, 100), std::pair(100, -1), std::pair(8193, 100),
                                        std::pair(100, 2'000'000'000));
  const auto canvas = make_canvas(width, height, view_of(tissue, 100, 100), TissueMesh(tissue, 0).mesh());
  REQUIRE_FALSE(canvas);
  CHECK_THAT(canvas.error().remedy, Contains("16 to 8192"));
}

TEST_CASE("The block stands in the middle, lit, and nothing is around it") {
  const TissueScene tissue = block({6, 6, 6});
  const TissueMesh mesh(tissue, 0);
  const auto canvas = canvas_for(tissue, mesh.mesh());
  if (!canvas) return;
  CHECK_FALSE(canvas->device().empty());
  const Image image = canvas->image();
  for (const int x : {0, 10, 309, 319})
    for (const int y : {0, 3, 236, 239}) CHECK(is_background(pixel(image, x, y)));
  const Seen block = seen(image);
  CHECK(std::abs(block.x - 159.5) < 2);
  CHECK(std::abs(block.y - 119.5) < 2);
  CHECK(block.pixels > 320 * 240 / 5);
  // The top is brighter than the front, because the light comes from above.
  const auto brightness = [&](int x, int y) { return pixel(image, x, y)[1]; };
  CHECK(brightness(160, 70) > brightness(200, 150));
}

TEST_CASE("What the particles do is seen: the picture moves with them, and is the same again when they are back") {
  const TissueScene tissue = block({6, 6, 6});
  TissueMesh mesh(tissue, 0);
  const auto canvas = canvas_for(tissue, mesh.mesh());
  if (!canvas) return;
  const Image first = canvas->image();
  const View view = view_of(tissue, 320, 240);
  ParticleState state = at_rest(tissue);
  for (glm::dvec3& moved : state.displacement_m) moved = 0.004 * view.right + 0.002 * view.up;
  mesh.move(state, {});
  REQUIRE(canvas->draw(mesh.mesh().positions_m));
  const Seen before = seen(first), after = seen(canvas->image());
  CHECK(after.x - before.x == Approx(0.004 / view.half_width_m * 160).margin(0.7));
  CHECK(before.y - after.y == Approx(0.002 / view.half_height_m * 120).margin(0.7));
  mesh.move(at_rest(tissue), {});
  REQUIRE(canvas->draw(mesh.mesh().positions_m));
  CHECK(canvas->image().pixels == first.pixels);
}

TEST_CASE("What is near hides what is far, whichever is drawn first") {
  const TissueScene tissue = with_tool(block({6, 6, 6}), CouplingKind::probe);
  TissueMesh mesh(tissue, 0);
  const auto canvas = canvas_for(tissue, mesh.mesh());
  if (!canvas) return;
  const View view = view_of(tissue, 320, 240);
  const auto blue_at_tool = [&](const glm::dvec3& moved_m) {
    mesh.move(at_rest(tissue), std::vector<DrawnTool>{{moved_m, glm::dvec3(0)}});
    REQUIRE(canvas->draw(mesh.mesh().positions_m));
    const glm::dvec3 clip = view.clip(tissue.tools[0].center_m + moved_m);
    const Pixel at = pixel(canvas->image(), static_cast<int>(160 + 160 * clip.x), static_cast<int>(120 - 120 * clip.y));
    return at[2] > at[0] + 20;
  };
  CHECK(blue_at_tool({0, 0, 0.002}));                       // half of the tool is above the surface
  CHECK(blue_at_tool({0.012, -0.02, -0.01}));               // in front of the block
  CHECK_FALSE(blue_at_tool(-0.012 * glm::dvec3(0, 0, 1)));  // in the middle of the block
  CHECK_FALSE(blue_at_tool(-0.04 * view.to_eye));           // behind the block
}

TEST_CASE("A drawing that is made in any shares is the same picture") {
  const TissueScene tissue = with_tool(block({6, 6, 6}), CouplingKind::probe);
  TissueMesh mesh(tissue, 0);
  const auto canvas = canvas_for(tissue, mesh.mesh());
  if (!canvas) return;
  const Image whole = canvas->image();
  for (const std::vector<int>& cuts : {std::vector<int>{0, 500, 1000}, {0, 1, 333, 334, 999, 1000}, {0, 970, 1000}}) {
    for (std::size_t n = 1; n < cuts.size(); ++n) {
      if (n + 1 == cuts.size()) CHECK(canvas->image().pixels != whole.pixels);  // the last share draws something
      REQUIRE(canvas->draw_share(mesh.mesh().positions_m, cuts[n - 1], cuts[n]));
    }
    CHECK(canvas->image().pixels == whole.pixels);
  }
}

TEST_CASE("Any thread may draw, one at a time, and several canvases do not disturb each other") {
  const TissueScene tissue = block({4, 4, 4}), other = block({3, 5, 2});
  const TissueMesh mesh(tissue, 0), other_mesh(other, 0);
  const auto canvas = canvas_for(tissue, mesh.mesh());
  if (!canvas) return;
  const auto second = canvas_for(other, other_mesh.mesh(), 64, 64);
  const Image first = canvas->image();
  std::jthread([&] {
    CHECK(second->draw(other_mesh.mesh().positions_m));
    CHECK(canvas->draw(mesh.mesh().positions_m));
  }).join();
  CHECK(canvas->image().pixels == first.pixels);
}

TEST_CASE("A PNG has the picture's size, and its rows can be unpacked") {
  if (!built_with_drawing()) {
    WARN("skipped: built without OpenGL");
    return;
  }
  Image image{3, 2, std::vector<std::uint8_t>(3 * 2 * 4, 200)};
  const auto png = png_of(image);
  REQUIRE(png);
  CHECK(png->substr(0, 8) == "\x89PNG\r\n\x1a\n");
  CHECK(png->substr(12, 4) == "IHDR");
  CHECK(static_cast<int>((*png)[19]) == 3);
  CHECK(static_cast<int>((*png)[23]) == 2);
  CHECK(png->substr(png->size() - 8, 4) == "IEND");
}
