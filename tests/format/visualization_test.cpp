// [timing] visualization: a pause, a drawing, or a device kept busy.
#include "catch.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

const std::string kFigure = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1.toml";
const std::string kSpringFile = std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/paper/figure-1-spring.toml";

ReadResult read_with(const std::string& visualization, bool real_time = false, const std::string& file = kFigure,
                     const std::string& more = "timing.paced=false") {
  return read_scenario(file, {{"timing.visualization=\"" + visualization + "\"", more}, {}, {}, real_time});
}

}  // namespace

TEST_CASE("A visualization is a pause, a drawing or a kernel of so long, or a drawing of a length that nobody knows") {
  const ReadResult pause = read_with("5 ms"), render = read_with("render 5 ms"), burn = read_with("burn 5 ms"),
                   unknown = read_with("render", true);
  REQUIRE((pause && render && burn && unknown));
  CHECK(pause->timing.work == VisualizationWork::pause);
  CHECK(render->timing.work == VisualizationWork::render);
  CHECK(burn->timing.work == VisualizationWork::burn);
  for (const ReadResult* one : {&pause, &render, &burn}) {
    CHECK((*one)->timing.programmed.visualization == Duration{5'000'000});
    CHECK((*one)->nominal.visualization == Duration{5'000'000});
    CHECK_FALSE((*one)->timing.real_steps);
  }
  CHECK(unknown->timing.work == VisualizationWork::render);
  CHECK(unknown->timing.real_steps);  // "fill" shares out what the visualization leaves
}

TEST_CASE("A drawing of unknown length needs a wall clock, and the error says what to write") {
  const ReadResult read = read_with("render");
  CHECK_FALSE(read);
  CHECK_THAT(errors_of(read), Contains("which only a wall clock can tell") && Contains("\"render 11.1 ms\"") &&
                                  Contains("evenstep record --visualization render"));
}

TEST_CASE("Only a tissue can be drawn, and a device can be kept busy whatever the scene is") {
  CHECK_THAT(errors_of(read_with("render 5 ms", false, kSpringFile)), Contains("draws a tissue, and this scene has none"));
  CHECK(read_with("burn 5 ms", false, kSpringFile));
}

TEST_CASE("What is no visualization is an error that says what is one") {
  const auto [written, error] =
      GENERATE(std::pair("rendr", "did you mean 'render'?"), std::pair("burn", "\"burn <time>\""),
               std::pair("burn 3 N", "'N' is a unit of force"), std::pair("render -1 ms", "is out of range"),
               std::pair("burn 0 ms", "must be above 0 s"), std::pair("render 0 s", "must be above 0 s"),
               std::pair("burn 2000000 s", "longer than 1e6 s"), std::pair("burn 40 ms", "leaves no time for steps"));
  INFO(written);
  CHECK_THAT(errors_of(read_with(written)), Contains(error));
}

TEST_CASE("A picture has a width and a height within its limits, and something that draws it") {
  CHECK(read_with("render 5 ms", false, kFigure, "timing.picture=[16, 8192]")->timing.picture_px == std::array{16, 8192});
  const auto [visualization, picture, error] = GENERATE(
      std::tuple("render 5 ms", "[15, 100]", "at least 16 and at most 8192"),
      std::tuple("render 5 ms", "[100, 8193]", "at least 16 and at most 8192"),
      std::tuple("render 5 ms", "[100]", "a width and a height"),
      std::tuple("render 5 ms", "[100, 100, 100]", "a width and a height"),
      std::tuple("render 5 ms", "[1.5, 100]", "whole number"), std::tuple("5 ms", "[100, 100]", "nothing is drawn here"));
  INFO(picture);
  CHECK_THAT(errors_of(read_with(visualization, false, kFigure, std::string("timing.picture=") + picture)), Contains(error));
}
