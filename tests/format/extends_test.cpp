#include <fmt/format.h>

#include <filesystem>

#include "catch.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

TEST_CASE("A file wins over its bases, later bases over earlier ones, tables merge, lists replace, expect_append adds") {
  const Folder folder;
  folder.write("base.toml", kSpring);
  folder.write("sub/other.toml",
               "format = 1\nextends = [\"../base.toml\"]\ntags = [\"a\", \"b\"]\n[timing]\nsteps = 10\n[run]\nseed = 7\n");
  const ReadResult result = read_scenario(
      folder.write("top.toml",
                   "format = 1\nextends = [\"base.toml\", \"sub/other.toml\"]\nname = \"top\"\n"
                   "timing.visualization = \"12 ms\"\n[[expect_append]]\nsignal = \"run\"\nmetric = \"x\"\nmax = 1\n"));
  INFO(errors_of(result));
  REQUIRE(result);
  const Scenario& s = *result;
  CHECK(s.name == "top");
  CHECK(s.because == "the smallest good file");
  CHECK(s.tags == std::vector<std::string>{"a", "b"});
  CHECK(s.seed == 7);
  CHECK(s.timing.programmed.steps == std::vector<int>{10});
  CHECK(s.timing.programmed.visualization.ns == 12'000'000);
  REQUIRE(s.expectations.size() == 2);
  CHECK(s.expectations[0].place.file == folder.path("base.toml"));
  CHECK(s.expectations[0].place.line == 18);
  CHECK(s.expectations[1].signal == "run");
  CHECK(s.expectations[1].place.line == 5);
  const ReadResult again = read_scenario(folder.write("resolved.toml", s.resolved_toml));
  INFO(s.resolved_toml << errors_of(again));
  REQUIRE(again);
  CHECK(describe(*again) == describe(s));
}

TEST_CASE("An error in a base file is reported at the base's line, one of the file that extends it at its own") {
  const Folder folder;
  std::string base = kSpring;
  base.replace(base.find("11.1 ms"), 7, "11.1 mm");
  folder.write("base.toml", base);
  const std::string top = folder.write("top.toml", "format = 1\nextends = [\"base.toml\"]\n[scene]\nstiffness = \"1 N\"\n");
  CHECK(errors_of(read_scenario(top)) ==
        "top.toml:4:13: error: 'stiffness': 'N' is a unit of force, not of stiffness\n"
        "base.toml:10:17: error: 'visualization': 'mm' is a unit of length, not of time\n");
  folder.write("broken.toml", "format = 1\nname = \n");
  CHECK_THAT(errors_of(read_scenario(folder.write("b.toml", "format = 1\nextends = [\"broken.toml\"]\n"))),
             Contains("broken.toml:2:"));
  CHECK_THAT(errors_of(read_scenario(folder.write("c.toml", "format = 1\nextends = [\"d.toml\"]\n"))),
             Contains("c.toml:2:12: error: '") && Contains("d.toml' no such file"));
  folder.write("old.toml", "name = \"no format\"\n");
  CHECK_THAT(errors_of(read_scenario(folder.write("e.toml", "format = 1\nextends = [\"old.toml\"]\n"))),
             Contains("old.toml:1:1: error: no 'format'"));
  CHECK_THAT(errors_of(read_scenario(folder.write("f.toml", "format = 1\nextends = \"old.toml\"\n"))),
             Contains("f.toml:2:11: error: 'extends' must be a list of files"));
  CHECK_THAT(errors_of(read_scenario(folder.write("g.toml", "format = 1\nexpect_append = 1\n"))),
             Contains("g.toml:2:17: error: 'expect_append' must be a list"));
}

TEST_CASE("Files that extend each other in a circle are refused with the chain, a base used twice is not a circle") {
  const Folder folder;
  folder.write("a.toml", "format = 1\nextends = [\"b.toml\"]\n");
  folder.write("b.toml", "format = 1\nextends = [\"./c.toml\"]\n");
  folder.write("c.toml", "format = 1\nextends = [\"a.toml\"]\n");
  const std::string errors = errors_of(read_scenario(folder.path("a.toml")));
  CHECK_THAT(errors, Contains("c.toml:2:12: error: 'extends' goes in a circle: " + folder.path("a.toml") + " -> " +
                              folder.path("b.toml") + " -> " + folder.path("c.toml") + " -> " + folder.path("a.toml")));
  folder.write("self.toml", "format = 1\nextends = [\"self.toml\"]\n");
  CHECK_THAT(errors_of(read_scenario(folder.path("self.toml"))), Contains("goes in a circle"));

  folder.write("base.toml", kSpring);
  folder.write("x.toml", "format = 1\nextends = [\"base.toml\"]\n");
  folder.write("y.toml", "format = 1\nextends = [\"base.toml\"]\n");
  CHECK(errors_of(read_scenario(folder.write("xy.toml", "format = 1\nextends = [\"x.toml\", \"y.toml\"]\n"))) == "");
}

TEST_CASE("Sixteen files in a chain are read and the seventeenth is refused") {
  const Folder folder;
  folder.write("f0.toml", kSpring);
  for (int i = 1; i <= 16; ++i)
    folder.write(fmt::format("f{}.toml", i), fmt::format("format = 1\nextends = [\"f{}.toml\"]\n", i - 1));
  CHECK(errors_of(read_scenario(folder.path("f15.toml"))) == "");
  CHECK_THAT(errors_of(read_scenario(folder.path("f16.toml"))),
             Contains("f1.toml:2:12: error: 'extends' is deeper than 16 files"));
}

TEST_CASE("The option --set changes one value, by index or by name, and needs no quotes") {
  const auto with = [](std::vector<std::string> set) {
    const ReadResult result = read_text(kTissue, {std::move(set), {}});
    INFO(errors_of(result));
    REQUIRE(result);
    return *result;
  };
  CHECK(with({"timing.visualization=22.2 ms"}).timing.programmed.visualization.ns == 22'200'000);
  CHECK(with({"timing.visualization=\"22.2 ms\""}).timing.programmed.visualization.ns == 22'200'000);
  CHECK(with({"timing.steps=[3, 4]"}).timing.programmed.steps == std::vector<int>{3, 4});
  CHECK(with({"device.0.rate=500 Hz"}).devices[0].rate == Rate{500, 1});
  CHECK(with({"device.right.rate=500 Hz"}).devices[1].rate == Rate{500, 1});
  CHECK(with({"device.right.motion.frequency=2 Hz"}).devices[1].name == "right");
  CHECK(with({"run.seed=3", "run.seed=4"}).seed == 4);
  CHECK(with({"remap.estimate.weight=0.5"}).remap.estimate_weight == 0.5);  // the table is created
  CHECK(with({"name=a = b"}).name == "a = b");
  CHECK(with({"expect.0.max=0.25"}).expectations[0].max->number == 0.25);
  CHECK(with({"scene.allow_unstable=true"}).scene.allow_unstable);
  CHECK(read_text(kSpring, {{}, 99})->seed == 99);
  CHECK(read_text(kSpring, {{}, 99})->timing.programmed.seed == 99);
  CHECK_THAT(with({"timing.visualization=22.2 ms"}).resolved_toml, Contains("22.2 ms"));
}

TEST_CASE("An element whose name begins with a digit is found by its name, and a number alone is an index") {
  std::string named = kTissue;
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"\"left\"", "\"1st\""}, {"\"right\"", "\"0\""}}) {
    for (std::size_t at = 0; (at = named.find(from, at)) != std::string::npos; at += to.size())
      named.replace(at, from.size(), to);
  }
  const ReadResult result = read_text(named, {{"device.1st.rate=500 Hz", "device.1.rate=250 Hz"}, {}});
  INFO(errors_of(result));
  REQUIRE(result);
  CHECK(result->devices[0].rate == Rate{500, 1});  // "1st", not the device of index 1
  CHECK(result->devices[1].rate == Rate{250, 1});
  CHECK_THAT(errors_of(read_text(named, {{"device.2nd.rate=500 Hz"}, {}})), Contains("there is no element named '2nd'"));
}

TEST_CASE("A mistake in --set is reported as one, with the assignment") {
  struct {
    const char* set;
    const char* error;
  } const rows[] = {
      {"timing.visualization=22.2 m",
       "--set timing.visualization=22.2 m: error: 'visualization': 'm' is a unit of length, not of time"},
      {"timing.vis=22.2 ms",
       "--set timing.vis=22.2 ms: error: unknown key 'vis' in [timing]; did you mean 'visualization'?"},
      {"timing.steps=0", "--set timing.steps=0: error: 'steps': 0 is out of range"},
      {"timing.steps", "error: write path=value"},
      {"=3", "error: write path=value"},
      {"timing..steps=3", "the path has an empty part"},
      {"device.2.rate=1 Hz", "there is no element 2; the list has 2, counted from 0"},
      {"device.middle.rate=1 Hz", "there is no element named 'middle'; write an index from 0 or one of: left, right"},
      {"timing.visualization.x=1", "there is nothing below \"11.1 ms\", so no 'x'"},
      {"extends=[\"x.toml\"]", "'extends' joins files before --set is applied"},
      {"format=2", "--set format=2: error: 'format': 2 is out of range"},
      {"run.seed=99999999999999999999", "'seed': \"99999999999999999999\" must be a whole number"},
      {"timing=3", "--set timing=3: error: 'timing': must be a table, not 3"},
      {"device=[]", "there is no [[device]]; a run needs one"},
  };
  for (const auto& row : rows) {
    INFO(row.set);
    const ReadResult result = read_text(kTissue, {{row.set}, {}});
    CHECK_THAT(errors_of(result), Contains(row.error));
  }
  // A line break cannot smuggle in a second key: the whole text is a name.
  CHECK(read_text(kTissue, {{"name=1\nformat = 2"}, {}})->name == "1\nformat = 2");
  CHECK_THAT(errors_of(read_text(kSpring, {{}, UINT64_MAX})),
             Contains("--seed: error: 18446744073709551615 is out of range"));
}
