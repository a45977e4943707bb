#include <fstream>
#include <sstream>

#include "catch.h"
#include "evenstep/time/build_option.h"

using namespace evenstep;

namespace {

std::string text_of(const std::string& file) {
  std::ifstream in(std::string(EVENSTEP_SOURCE_DIR) + "/" + file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

/// "a, b and c" as its words, without "and".
std::vector<std::string> words(std::string_view list) {
  std::vector<std::string> found;
  std::istringstream in{std::string(list)};
  for (std::string word; in >> word;) {
    if (word.ends_with(',')) word.pop_back();
    if (word != "and") found.push_back(word);
  }
  return found;
}

}  // namespace

TEST_CASE("what a build lacks is refused with its name, what else would do, and how to get it") {
  CHECK(built_without(build_option::kOpenCl) == "this evenstep is built without OpenCL");
  CHECK(refusal_without(build_option::kDraw) ==
        "this evenstep is built without OpenGL; build it with -D EVENSTEP_DRAW=ON, which needs libegl-dev, libgles-dev and "
        "zlib1g-dev");
  CHECK(refusal_without(build_option::kProfiles, "unpack it first") ==
        "this evenstep is built without SQLite and zlib; unpack it first, or build it with -D EVENSTEP_PROFILES=ON, which "
        "needs libsqlite3-dev and zlib1g-dev");
}

TEST_CASE("each build option is one of CMake, with a row on the page, and needs packages that are installed") {
  const std::string cmake = text_of("CMakeLists.txt") + text_of("cmake/EvenstepBeast.cmake"),
                    page = text_of("docs/begin/install.md"), packages = text_of("scripts/packages.txt");
  for (const BuildOption& option : kBuildOptions) {
    INFO(option.name);
    CHECK(cmake.find("option(" + std::string(option.name) + " ") != std::string::npos);
    CHECK(page.find("| `" + std::string(option.name) + "` | ") != std::string::npos);
    for (const std::string& package : words(option.needs)) {
      INFO(package);
      CHECK(packages.find("\n" + package + " ") != std::string::npos);
    }
  }
}
