#include <fmt/format.h>

#include <filesystem>

#include "catch.h"
#include "evenstep/format/scenario.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

TEST_CASE("A file wins over its bases, later bases over earlier ones, tables merge, lists replace, expect_append adds") {
  const TemporaryFolder folder;
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
  CHECK(s.expectations[0].place.file == folder / "base.toml");
  CHECK(s.expectations[0].place.line == 18);
  CHECK(s.expectations[1].signal == "run");
  CHECK(s.expectations[1].place.line == 5);
  const ReadResult again = read_scenario(folder.write("resolved.toml", s.resolved_toml));
  INFO(s.resolved_toml << errors_of(again));
  REQUIRE(again);
  CHECK(describe(*again) == describe(s));
}

namespace {

/// Which file each expectation comes from, in order, with its line.
std::string expectations_of(const ReadResult& result) {
  INFO(errors_of(result));
  REQUIRE(result);
  std::string all;
  for (const Expectation& one : result->expectations)
    all += fmt::format("{}:{} ", std::filesystem::path(one.place.file).filename().string(), one.place.line);
  return all;
}

/// The notes, one per line, with file names cut to their last part.
std::string notes_of(const ReadResult& result, const TemporaryFolder& folder) {
  INFO(errors_of(result));
  REQUIRE(result);
  std::string all;
  for (const Diagnostic& note : result->notes) all += fmt::format("{}:{}: {}\n", note.file, note.line, note.message);
  const std::string here = folder / "";
  for (std::size_t at = 0; (at = all.find(here)) != std::string::npos;) all.erase(at, here.size());
  return all;
}

std::string extending(const std::string& files, const std::string& rest = "") {
  return "format = 1\nextends = [" + files + "]\n" + rest;
}

const std::string kAppended = "[[expect_append]]\nsignal = \"run\"\nmetric = \"judged_s\"\nmin = 0\n";

}  // namespace

TEST_CASE("What expect_append adds in any of the files stays, in their order, whatever the files beside it say") {
  const TemporaryFolder folder;
  folder.write("base.toml", kSpring);
  folder.write("one.toml", extending("\"base.toml\"", kAppended));
  folder.write("two.toml", extending("\"base.toml\"", kAppended));
  const auto expectations = [&](const std::string& files, const std::string& rest = "") {
    return expectations_of(read_scenario(folder.write("top.toml", extending(files, rest))));
  };
  CHECK(expectations("\"one.toml\", \"two.toml\"") == "base.toml:18 one.toml:3 two.toml:3 ");
  CHECK(expectations("\"two.toml\", \"one.toml\"", kAppended) == "base.toml:18 two.toml:3 one.toml:3 top.toml:3 ");
  // A fragment has no expectations that its own could be added to.
  folder.write("fragment.toml", "format = 1\n" + kAppended);
  CHECK(expectations("\"fragment.toml\", \"base.toml\"") == "base.toml:18 fragment.toml:2 ");
  CHECK(expectations("\"base.toml\", \"fragment.toml\"") == "base.toml:18 fragment.toml:2 ");
  // A file that comes in twice adds once.
  folder.write("three.toml", extending("\"one.toml\"", kAppended));
  CHECK(expectations("\"one.toml\", \"three.toml\"") == "base.toml:18 one.toml:3 three.toml:3 ");
  // [[expect]] replaces the [[expect]] of the bases and nothing else.
  CHECK(expectations("\"one.toml\"", "[[expect]]\nsignal = \"run\"\nmetric = \"judged_s\"\nmin = 0\n") ==
        "top.toml:3 one.toml:3 ");
}

TEST_CASE(
    "A list of tables that another file replaces is named, and so is a value that a file which comes in again takes back") {
  const TemporaryFolder folder;
  folder.write("base.toml", kSpring);
  folder.write("one.toml", extending("\"base.toml\"", kAppended));
  const std::string device = "[[device]]\nname = \"left\"\nrate = \"500 Hz\"\nmotion = { kind = \"still\" }\n";
  folder.write("two.toml", extending("\"base.toml\"", device));
  const auto notes = [&](const std::string& files, const std::string& rest = "") {
    return notes_of(read_scenario(folder.write("top.toml", extending(files, rest))), folder);
  };
  CHECK(notes("\"base.toml\", \"one.toml\"") == "");
  CHECK(notes("\"base.toml\"", "tags = [\"a\"]\ntiming.steps = [10]\n") == "");
  CHECK(notes("\"two.toml\"") ==
        "two.toml:3: 'device' replaces the list of 1 at base.toml:15:1, because lists are not joined\n");
  // A file that comes in twice says it once.
  folder.write("three.toml", extending("\"two.toml\""));
  CHECK(notes("\"two.toml\", \"three.toml\"") == notes("\"two.toml\""));
  // The second file brings in the list of its own base again, and so the first one's is lost.
  CHECK(notes("\"two.toml\", \"one.toml\"") ==
        notes("\"two.toml\"") +
            "base.toml:15: 'device' replaces the list of 1 at two.toml:3:1, because this file comes in once "
            "more after that one\n");
  folder.write("steps.toml", extending("\"base.toml\"", "timing.steps = 10\n"));
  CHECK(notes("\"steps.toml\", \"one.toml\"") ==
        "base.toml:11: 'steps' replaces 10 at steps.toml:3:16, because this file comes in once more after that one\n");
  CHECK(notes("\"one.toml\", \"steps.toml\"") == "");
  CHECK_THAT(notes("\"one.toml\"", "[[expect]]\nsignal = \"run\"\nmetric = \"judged_s\"\nmin = 0\n"),
             Contains("top.toml:3: 'expect' replaces the list of 1 at base.toml:18:1") &&
                 Contains("[[expect_append]] would add to it"));
}

TEST_CASE("An error in a base file is reported at the base's line, one of the file that extends it at its own") {
  const TemporaryFolder folder;
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
  const TemporaryFolder folder;
  folder.write("a.toml", "format = 1\nextends = [\"b.toml\"]\n");
  folder.write("b.toml", "format = 1\nextends = [\"./c.toml\"]\n");
  folder.write("c.toml", "format = 1\nextends = [\"a.toml\"]\n");
  const std::string errors = errors_of(read_scenario(folder / "a.toml"));
  CHECK_THAT(errors, Contains("c.toml:2:12: error: 'extends' goes in a circle: " + folder / "a.toml" + " -> " +
                              folder / "b.toml" + " -> " + folder / "c.toml" + " -> " + folder / "a.toml"));
  folder.write("self.toml", "format = 1\nextends = [\"self.toml\"]\n");
  CHECK_THAT(errors_of(read_scenario(folder / "self.toml")), Contains("goes in a circle"));

  folder.write("base.toml", kSpring);
  folder.write("x.toml", "format = 1\nextends = [\"base.toml\"]\n");
  folder.write("y.toml", "format = 1\nextends = [\"base.toml\"]\n");
  CHECK(errors_of(read_scenario(folder.write("xy.toml", "format = 1\nextends = [\"x.toml\", \"y.toml\"]\n"))) == "");
}

TEST_CASE("Sixteen files in a chain are read and the seventeenth is refused") {
  const TemporaryFolder folder;
  folder.write("f0.toml", kSpring);
  for (int i = 1; i <= 16; ++i)
    folder.write(fmt::format("f{}.toml", i), fmt::format("format = 1\nextends = [\"f{}.toml\"]\n", i - 1));
  CHECK(errors_of(read_scenario(folder / "f15.toml")) == "");
  CHECK_THAT(errors_of(read_scenario(folder / "f16.toml")),
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

TEST_CASE("An assignment that would take the effect of another one is refused, unless the same path is given again") {
  const auto error = [](std::vector<std::string> set) { return errors_of(read_text(kTissue, {std::move(set), {}})); };
  CHECK_THAT(
      error({"device.left.rate=500 Hz", "device.0.rate=1 kHz"}),
      Contains("--set device.0.rate=1 kHz: error: sets again what --set device.left.rate=500 Hz has set, which has no "
               "effect then; remove one of them"));
  CHECK_THAT(error({"device.00.rate=500 Hz", "device.0.rate=1 kHz"}), Contains("remove one of them"));
  CHECK_THAT(
      error({"timing.jitter.step=lognormal 10 %", "timing.jitter={ visualization = \"lognormal 10 %\" }"}),
      Contains("sets again what --set timing.jitter.step=lognormal 10 % has set") && Contains("write this one first"));
  CHECK(error({"timing.jitter={ visualization = \"lognormal 10 %\" }", "timing.jitter.step=lognormal 10 %"}) == "");
  CHECK(error({"timing.steps=10", "timing.visualization=11 ms", "device.0.rate=1 kHz", "device.1.rate=1 kHz"}) == "");
  CHECK(error({"device.0.rate=500 Hz", "device.0.rate=1 kHz"}) == "");
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
      {"latency=3",
       "--set latency=3: error: unknown key 'latency' in the top of the file; such a key is recovery.latency, or "
       "remap.latency"},
      {"rate=3", "in the top of the file; such a key is device.NAME.rate, or timing.preemption.rate"},
      {"timing.lead=3", "unknown key 'lead' in [timing]; such a key is remap.lead"},
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
