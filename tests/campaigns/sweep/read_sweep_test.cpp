// How [sweep] is read, and which mistakes in it are reported.
#include <fmt/format.h>

#include "catch.h"
#include "evenstep/campaigns/sweep.h"
#include "files.h"

using namespace evenstep;
using Catch::Contains;
using testing::TemporaryFolder;

namespace {

SweepSpec read(const std::string& sweep) {
  TemporaryFolder folder;
  const ReadResult result = read_scenario(folder.write("x.toml", test::small_scenario(sweep)));
  for (const Diagnostic& error : result.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(result);
  REQUIRE(result->sweep);
  return *result->sweep;
}

std::vector<std::string> values(const std::string& value) {
  return read("[sweep.grid]\n\"remap.latency\" = " + value + "\n").grid.front().values;
}

/// All errors of the scenario and its points, in one text.
std::string errors(const std::string& sweep) {
  TemporaryFolder folder;
  std::string out;
  for (const Diagnostic& error : check_sweep(folder.write("x.toml", test::small_scenario(sweep)), {}))
    out += text(error) + "\n";
  return out;
}

}  // namespace

TEST_CASE("Seeds are a span without its end or a list of numbers and spans") {
  CHECK(read("[sweep]\nseeds = \"0..30000\"\n").seeds.size() == 30'000);
  CHECK(read("[sweep]\nseeds = \"0..30000\"\n").seeds.back() == 29'999);
  CHECK(read("[sweep]\nseeds = [5, \"10..12\", 1]\n").seeds == std::vector<std::uint64_t>{5, 10, 11, 1});
  CHECK(read("[sweep]\nkeep_worst = 1\n").seeds == std::vector<std::uint64_t>{1});
  for (const char* bad :
       {"\"5..5\"", "\"6..5\"", "\"a..5\"", "\"5\"", "\"0..1e3\"", "[1, \"0..3\"]", "\"0..99999999999\"", "-1"}) {
    INFO(bad);
    CHECK_THAT(errors(fmt::format("[sweep]\nseeds = {}\n", bad)), Contains("x.toml:14:") && Contains("'seeds'"));
  }
}

TEST_CASE("A range has its ends as written and evenly spaced values between, times to a nanosecond") {
  CHECK(values("{ from = \"5 ms\", to = \"20 ms\", count = 7 }") ==
        std::vector<std::string>{"\"5 ms\"", "\"7.5 ms\"", "\"10 ms\"", "\"12.5 ms\"", "\"15 ms\"", "\"17.5 ms\"",
                                 "\"20 ms\""});
  CHECK(values("{ from = \"0 us\", to = \"1 us\", count = 4 }") ==
        std::vector<std::string>{"\"0 us\"", "\"0.333 us\"", "\"0.667 us\"", "\"1 us\""});
  CHECK(values("[\"minimal\", { from = \"10 ns\", to = \"30 ns\", count = 3 }]") ==
        std::vector<std::string>{"\"minimal\"", "\"10 ns\"", "\"20 ns\"", "\"30 ns\""});
  CHECK(values("{ from = 5, to = 20, count = 4 }") == std::vector<std::string>{"5", "10", "15", "20"});
}

TEST_CASE("What is wrong with a sweep is named with its place") {
  const auto grid = [](const std::string& line) { return errors("[sweep.grid]\n" + line + "\n"); };
  CHECK_THAT(grid("\"timing.visualisation\" = [\"5 ms\"]"), Contains("x.toml:14:1: error: unknown key 'visualisation'"));
  CHECK_THAT(grid("\"timing.visualization\" = [\"5 ms\", \"50 ms\"]"),
             Contains("x.toml:14:1: error: 'visualization': V = 50 ms"));
  CHECK_THAT(grid("\"device.right.rate\" = [\"1 kHz\"]"), Contains("x.toml:14:1: error: there is no element named 'right'"));
  CHECK_THAT(grid("timing.visualization = [\"5 ms\"]"), Contains("a path stands in quotes"));
  CHECK_THAT(grid("\"run.seed\" = [1]"), Contains("x.toml:14:1: error: seeds have a key of their own"));
  CHECK_THAT(grid("\"sweep.seeds\" = [1]"), Contains("cannot be part of a grid"));
  CHECK_THAT(grid("\"remap.latency\" = [\"5 ms\", \"5 ms\"]"), Contains("is there twice"));
  CHECK_THAT(grid("\"remap.latency\" = [\"0.009 s\", \"9 ms\"]"), Contains("is there twice: it equals \"0.009 s\""));
  CHECK_THAT(grid("\"scene.stiffness\" = [\"1 N/m\", \"1.0 N/m\"]"), Contains("is there twice"));
  CHECK_THAT(grid("\"timing.slowdown\" = [1, 1.0]"), Contains("is there twice"));
  CHECK_THAT(grid("\"remap.latency\" = [\"1 segment\", \"1 segments\"]"), Contains("is there twice: it equals"));
  CHECK_THAT(grid("\"remap.latency\" = []"), Contains("x.toml:14:"));
  CHECK_THAT(grid("\"remap.latency\" = { from = \"5 ms\", to = \"1 ms\", count = 3 }"),
             Contains("'to' must be above 'from'"));
  CHECK_THAT(grid("\"remap.latency\" = { from = \"5 ms\", to = \"1 s\", count = 3 }"), Contains("same unit"));
  CHECK_THAT(grid("\"remap.latency\" = { from = \"5 ms\", to = \"9 ms\" }"), Contains("has no 'count'"));
  CHECK_THAT(grid("\"timing.steps\" = { from = 1, to = 4, count = 3 }"), Contains("not evenly spaced"));
  CHECK(errors("[sweep]\nseeds = \"0..3\"\n").empty());
}

TEST_CASE("Two axes that set the same key, or one within the other, are refused: one of them would have no effect") {
  const auto grid = [](const std::string& lines) { return errors("[sweep.grid]\n" + lines + "\n"); };
  CHECK_THAT(grid("\"device.left.rate\" = [\"1 kHz\", \"2 kHz\"]\n\"device.0.rate\" = [\"500 Hz\", \"1 kHz\"]"),
             Contains("x.toml:15:1: error: 'device.0.rate' sets what 'device.left.rate' of this grid sets; remove one"));
  for (const char* lines : {"\"timing.steps\" = [[10, 15], [12, 15]]\n\"timing.steps.0\" = [10, 12]",
                            "\"timing.steps.0\" = [10, 12]\n\"timing.steps\" = [[10, 15], [12, 15]]"}) {
    INFO(lines);
    CHECK_THAT(grid(lines), Contains("x.toml:15:1: error: '") && Contains("of this grid sets; remove one of them"));
  }
  CHECK(grid("\"remap.latency\" = [\"20 ms\"]\n\"timing.steps\" = [10]\n\"device.0.rate\" = [\"1 kHz\"]") == "");
}

TEST_CASE("An assignment that every point of a sweep sets itself is refused, because it would have no effect") {
  TemporaryFolder folder;
  const std::string file = folder.write(
      "x.toml", test::small_scenario("[sweep]\nseeds = \"0..2\"\ngrid = { \"device.left.rate\" = [\"1 kHz\"] }\n"));
  const auto sweep_with = [&](const std::string& assignment) {
    SweepOptions options;
    options.set = {assignment};
    options.folder = folder / "out";
    std::string all;
    for (const Diagnostic& error : run_sweep(file, options).errors) all += text(error) + "\n";
    return all;
  };
  CHECK_THAT(sweep_with("device.0.rate=500 Hz"),
             Contains("--set device.0.rate=500 Hz: error: has no effect: every point takes this from [sweep.grid]"));
  CHECK_THAT(sweep_with("run.seed=7"), Contains("--set run.seed=7: error: has no effect: [sweep] has seeds"));
  CHECK(sweep_with("timing.steps=14") == "");
}

TEST_CASE("What a sweep finds must be a key of its grid with rising values, and its gate one of them") {
  const auto find = [](const std::string& values, const std::string& line) {
    return errors(fmt::format("[sweep.grid]\n\"remap.latency\" = {}\n[sweep.find]\n{}\n", values, line));
  };
  const std::string rising = "[\"900 us\", \"5 ms\", \"0.01 s\"]";
  CHECK(find(rising, "smallest = \"remap.latency\"\nat_most = \"6 ms\"").empty());
  const std::string seconds = "[\"0.009 s\", \"0.012 s\"]";  // 9 * 1e-3 is not 0.009
  CHECK(find("[\"9 ms\", \"12 ms\"]", "smallest = \"remap.latency\"\nat_most = \"0.009 s\"").empty());
  CHECK(find(seconds, "smallest = \"remap.latency\"\nat_most = \"9 ms\"").empty());
  CHECK(find(seconds, "largest = \"remap.latency\"\nat_least = \"12 ms\"").empty());
  CHECK_THAT(find("[\"0.009 s\", \"9 ms\"]", "smallest = \"remap.latency\""), Contains("does not come after"));
  CHECK(find(rising, "largest = \"remap.latency\"\nat_least = \"6 ms\"").empty());
  CHECK_THAT(find(rising, "smallest = \"remap.lead\""), Contains("x.toml:16:") && Contains("no key of [sweep.grid]"));
  CHECK_THAT(find(rising, "where = \"all-pass\""), Contains("'smallest' or 'largest'"));
  CHECK_THAT(find(rising, "smallest = \"remap.latency\"\nat_least = \"6 ms\""), Contains("write 'at_most'"));
  CHECK_THAT(find(rising, "smallest = \"remap.latency\"\nat_most = \"1 us\""), Contains("no value of the grid is within"));
  CHECK_THAT(find(rising, "smallest = \"remap.latency\"\nat_most = \"6 Hz\""), Contains("cannot be compared"));
  CHECK_THAT(find("[\"5 ms\", \"4 ms\"]", "smallest = \"remap.latency\""), Contains("does not come after"));
  CHECK_THAT(find("[\"minimal\"]", "smallest = \"remap.latency\""), Contains("is no number with a unit"));
  CHECK_THAT(
      errors(
          "[sweep]\nstop_after = 3\ngrid = { \"remap.latency\" = [\"5 ms\"] }\nfind = { smallest = \"remap.latency\" }\n"),
      Contains("'stop_after' does not go with [sweep.find]"));
}

TEST_CASE("The digest of a sweep follows what its files say and not where they lie") {
  const auto digest = [](const std::string& rows, const std::string& set = "") {
    TemporaryFolder folder;
    folder.write("t.csv", "segment,kind,index,begin_ns,end_ns\n" + rows);
    const std::string scenario = folder.write(
        "x.toml",
        "format = 1\n[timing]\ntrace = \"t.csv\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"left\"\n"
        "motion = { kind = \"still\" }\n[[expect]]\nsignal = \"left.force.direct\"\nmetric = \"underruns\"\nequals = 0\n"
        "[sweep]\nseeds = [1]\n");
    SweepOptions options;
    options.folder = folder / "out";
    if (!set.empty()) options.set = {set};
    const SweepOutcome outcome = run_sweep(scenario, options);
    for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
    REQUIRE(outcome.errors.empty());
    return outcome.header.scenario;
  };
  const std::string rows = "0,step,0,0,2000000\n0,step,1,2000000,4000000\n1,step,0,4000000,6000000\n";
  CHECK(digest(rows) == digest(rows));
  CHECK(digest(rows) != digest(rows + "1,step,1,6000000,8000000\n"));
  CHECK(digest(rows) != digest(rows, "scene.stiffness=100 N/m"));
}
