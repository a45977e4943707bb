#include "evenstep/apps/shell.h"

#include "catch.h"
#include "src/progress.h"

using namespace evenstep;

TEST_CASE("A command starts with what its user typed, quoted if need be") {
  CHECK(program_words("./run.sh", "/build/apps/evenstep") == "./run.sh");
  CHECK(program_words(nullptr, "build/apps/evenstep") == "build/apps/evenstep");
  CHECK(program_words("", "evenstep") == "evenstep");
  CHECK(program_words("../my clone/run.sh", nullptr) == "'../my clone/run.sh'");
  CHECK(program_words(nullptr, nullptr) == "evenstep");
}

TEST_CASE("A command that a message names can be typed as it is") {
  CHECK(with_program("`evenstep devices` lists them; `evenstep list`, too", "./run.sh") ==
        "`./run.sh devices` lists them; `./run.sh list`, too");
  CHECK(with_program("evenstep 0.1.0 is no command, nor is `evenstep`", "x") ==
        "evenstep 0.1.0 is no command, nor is `evenstep`");
  CHECK(with_program("", "x").empty());
}

TEST_CASE("A file is never taken for an option") {
  CHECK(shell_file("a.toml") == "a.toml");
  CHECK(shell_file("-x.toml") == "./-x.toml");
  CHECK(shell_file("-x y.toml") == "'./-x y.toml'");
}

TEST_CASE("what is counted is followed by more only where there is more") {
  using app::count_words;
  CHECK(count_words(23, 108, "4 failed") == "  23 of 108, 4 failed");
  CHECK(count_words(23, 108, "") == "  23 of 108");
  CHECK(count_words(23, 0, "") == "  23 runs");
}
