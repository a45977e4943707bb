#include "evenstep/text/text_file.h"

#include <filesystem>

#include "catch.h"
#include "temporary_folder.h"

using namespace evenstep::internal;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::ptrdiff_t files_in(const TemporaryFolder& folder) {
  return std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator());
}

}  // namespace

TEST_CASE("A file that is written is there as a whole, also in the place of another one, and nothing else is") {
  const TemporaryFolder place;
  for (const std::string text : {"one\n", "", "another\n"}) {
    CHECK(write_objection(place / "a").empty());
    CHECK(write_text_file(place / "a", text).empty());
    CHECK(read_text_file(place / "a", 100).value_or("?") == text);
    CHECK(files_in(place) == 1);
  }
}

TEST_CASE("What cannot be written says why, and leaves nothing") {
  const TemporaryFolder place;
  CHECK_THAT(write_text_file(place / "none/a", "x"), Contains("there is no folder"));
  CHECK_THAT(write_text_file(place.path().string(), "x"), Contains("is a directory"));
  CHECK_THAT(write_objection(place / "none/a"), Contains("there is no folder"));
  CHECK(files_in(place) == 0);
}

TEST_CASE("What a killed process has left is removed by the next one that writes there, and by none that writes elsewhere") {
  const TemporaryFolder place;
  const fs::path left = place.path() / ".a.writing-1";
  REQUIRE(fs::create_directory(left));
  CHECK(write_text_file((left / "new").string(), "half").empty());
  CHECK(write_text_file(place / "b", "x").empty());
  CHECK(fs::exists(left / "new"));
  CHECK(write_text_file(place / "a", "whole").empty());
  CHECK_FALSE(fs::exists(left));
  CHECK(read_text_file(place / "a", 100).value_or("?") == "whole");
  CHECK(files_in(place) == 2);
}

TEST_CASE("A device is written to as it is, and a full one is an error") {
  CHECK(write_text_file("/dev/null", "x").empty());
  CHECK_THAT(write_text_file("/dev/full", "x"), Contains("No space left on device"));
  CHECK(fs::is_character_file("/dev/null"));
  CHECK(fs::is_character_file("/dev/full"));
}

TEST_CASE("A path that another machine may read names no folder above the working directory") {
  const fs::path before = fs::current_path();
  const TemporaryFolder place;
  fs::create_directories(place.path() / "a");
  fs::current_path(place.path());
  CHECK(portable_path("a/x.toml") == "a/x.toml");
  CHECK(portable_path("./a/../a/x.toml") == "a/x.toml");
  CHECK(portable_path(place / "a/x.toml") == "a/x.toml");
  CHECK(portable_path("../x.toml") == "x.toml");
  CHECK(portable_path("a/../../x.toml") == "x.toml");
  CHECK(portable_path("/somewhere/else/x.toml") == "x.toml");
  fs::create_directory_symlink(place.path(), place.path() / "a" / "again");
  CHECK(portable_path(place / "a/again/x.toml") == "a/again/x.toml");
  fs::current_path(place.path() / "a" / "again");
  CHECK(portable_path(place / "a/x.toml") == "a/x.toml");
  fs::current_path(before);
}
