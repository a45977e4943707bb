#include "evenstep/text/text_file.h"

#include <filesystem>

#include "catch.h"

using namespace evenstep::internal;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

struct Place {
  fs::path folder = fs::temp_directory_path() / ("evenstep-text-" + std::to_string(std::hash<std::string>{}(__FILE__)));
  Place() { fs::create_directories(folder); }
  ~Place() { fs::remove_all(folder); }
  std::string path(const char* name) const { return (folder / name).string(); }
  std::ptrdiff_t files() const { return std::distance(fs::directory_iterator(folder), fs::directory_iterator()); }
};

}  // namespace

TEST_CASE("A file that is written is there as a whole, also in the place of another one, and nothing else is") {
  const Place place;
  for (const std::string text : {"one\n", "", "another\n"}) {
    CHECK(write_objection(place.path("a")).empty());
    CHECK(write_text_file(place.path("a"), text).empty());
    CHECK(read_text_file(place.path("a"), 100).value_or("?") == text);
    CHECK(place.files() == 1);
  }
}

TEST_CASE("What cannot be written says why, and leaves nothing") {
  const Place place;
  CHECK_THAT(write_text_file(place.path("none/a"), "x"), Contains("there is no folder"));
  CHECK_THAT(write_text_file(place.folder.string(), "x"), Contains("is a directory"));
  CHECK_THAT(write_objection(place.path("none/a")), Contains("there is no folder"));
  CHECK(place.files() == 0);
}

TEST_CASE("What a killed process has left is removed by the next one that writes there, and by none that writes elsewhere") {
  const Place place;
  const fs::path left = place.folder / ".a.writing-1";
  REQUIRE(fs::create_directory(left));
  CHECK(write_text_file((left / "new").string(), "half").empty());
  CHECK(write_text_file(place.path("b"), "x").empty());
  CHECK(fs::exists(left / "new"));
  CHECK(write_text_file(place.path("a"), "whole").empty());
  CHECK_FALSE(fs::exists(left));
  CHECK(read_text_file(place.path("a"), 100).value_or("?") == "whole");
  CHECK(place.files() == 2);
}

TEST_CASE("A device is written to as it is, and a full one is an error") {
  CHECK(write_text_file("/dev/null", "x").empty());
  CHECK_THAT(write_text_file("/dev/full", "x"), Contains("No space left on device"));
  CHECK(fs::is_character_file("/dev/null"));
  CHECK(fs::is_character_file("/dev/full"));
}

TEST_CASE("A path that another machine may read names no folder above the working directory") {
  const fs::path before = fs::current_path();
  const Place place;
  fs::create_directories(place.folder / "a");
  fs::current_path(place.folder);
  CHECK(portable_path("a/x.toml") == "a/x.toml");
  CHECK(portable_path("./a/../a/x.toml") == "a/x.toml");
  CHECK(portable_path(place.path("a/x.toml")) == "a/x.toml");
  CHECK(portable_path("../x.toml") == "x.toml");
  CHECK(portable_path("a/../../x.toml") == "x.toml");
  CHECK(portable_path("/somewhere/else/x.toml") == "x.toml");
  fs::create_directory_symlink(place.folder, place.folder / "a" / "again");
  CHECK(portable_path(place.path("a/again/x.toml")) == "a/again/x.toml");
  fs::current_path(place.folder / "a" / "again");
  CHECK(portable_path(place.path("a/x.toml")) == "a/x.toml");
  fs::current_path(before);
}
