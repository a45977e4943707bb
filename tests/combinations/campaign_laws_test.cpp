// Laws of what runs a scenario many times, or outside of virtual time.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "catch.h"
#include "law_bench.h"

using namespace evenstep;
using namespace evenstep::testing;
namespace fs = std::filesystem;

namespace {

/// Leaves out what asks for an end of its own. False for a scenario that is about such an end.
bool make_plain(GeneratedScenario& drawn) {
  if (drawn.root.has("case") || drawn.root.has("expect_stop")) return false;
  for (const char* const key : {"expect", "sometimes", "sweep", "study", "recovery"}) drawn.root.erase(key);
  drawn.toml = to_text(drawn.root).toml;
  return true;
}

const std::string kNeverLate = "[[expect]]\nsignal = \"*.force.phase_locked\"\nmetric = \"late\"\nmax = 0\n";

}  // namespace

TEST_CASE("A sweep in shards, in one go, on other threads, or cut off in a line and resumed, has the same lines") {
  judge_drawn(6, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    const std::uint64_t seed = law.seed;
    if (!make_plain(drawn)) return false;
    const std::string toml = drawn.toml + kNeverLate +
                             "[sweep]\nseeds = [1, 7]\n[sweep.grid]\n\"remap.latency\" = [\"8 ms\", \"30 ms\", \"60 ms\"]\n";
    std::ofstream(bench.scenario()) << toml;
    const Ended whole = bench.program({"sweep", "scenario.toml", "--out", "whole", "--threads", "1"});
    const std::string lines = content_of(bench.path() + "/whole/sweep.jsonl");
    if (whole.exit_code > 1 || lines.empty()) return false;
    law.shows(toml + whole.text());

    std::vector<std::string> merge{"merge"};
    for (const char* const shard : {"3/3", "1/3", "2/3"}) {
      const Ended part = bench.program({"sweep", "scenario.toml", "--out", "parts", "--threads", "2", "--shard", shard});
      law.shows(part.text());
      MUST(part.exit_code <= 1);
      merge.push_back(fmt::format("parts/sweep-{}-of-3.jsonl", shard[0]));
    }
    merge.insert(merge.end(), {"--out", "merged.jsonl"});
    const Ended merged = bench.program(merge);
    law.shows(merged.text());
    MUST(merged.exit_code == whole.exit_code);
    MUST(content_of(bench.path() + "/merged.jsonl") == lines);

    fs::create_directories(bench.path() + "/cut");
    const std::size_t kept = lines.find('\n') + 1 + (lines.size() - lines.find('\n')) * (seed % 7) / 8;
    std::ofstream(bench.path() + "/cut/sweep.jsonl") << lines.substr(0, kept);
    const Ended resumed = bench.program({"sweep", "scenario.toml", "--out", "cut", "--threads", "2", "--resume"});
    law.shows(resumed.text());
    MUST(resumed.exit_code == whole.exit_code);
    MUST(content_of(bench.path() + "/cut/sweep.jsonl") == lines);
    for (const char* const folder : {"whole", "parts", "cut"}) fs::remove_all(bench.path() + '/' + folder);
    return true;
  });
}

TEST_CASE("What fails is shrunk to what still fails, and two runs of it do not differ") {
  judge_drawn(10, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (!make_plain(drawn) || drawn.root.has("source")) return false;  // shrink takes the timing apart, not what is lost
    const std::vector<std::string> too_little{"--set", "remap.latency=\"2 ms\"", "--set",
                                              "run.strategies=[\"phase_locked\"]"};
    const std::string toml = drawn.toml + kNeverLate;
    const Bench::Run run = bench.run(toml, "run", too_little);
    if (run.ended.exit_code != 1 || !run.summary.is_object()) return false;
    law.shows(toml + run.ended.text());
    MUST(bench.run(toml, "again", too_little).ended.exit_code == 1);
    const Ended diff = bench.program({"diff", "run", "again"});
    law.shows(diff.text());
    MUST(diff.exit_code == 0);

    std::vector<std::string> arguments{"shrink", "scenario.toml", "--out", "shrunk", "--max-runs", "60"};
    arguments.insert(arguments.end(), too_little.begin(), too_little.end());
    const Ended shrink = bench.program(arguments);
    law.shows(shrink.text());
    MUST(shrink.exit_code == 0);
    const Ended smaller = bench.program({"run", "shrunk/scenario-shrunk.toml", "--out", "smaller"});
    law.shows(smaller.text());
    MUST(smaller.exit_code == 1);
    fs::remove_all(bench.path() + "/shrunk");
    return true;
  });
}

TEST_CASE("A live run of a drawn scenario with simulated devices, recorded, is replayed to the same hash") {
  judge_drawn(16, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (!make_plain(drawn)) return false;
    std::ofstream(bench.scenario()) << drawn.toml;
    const Ended live = bench.program({"run", "scenario.toml", "--clock", "wall", "--out", "live", "--record", "live.inputs",
                                      "--allow-no-expectations", "--cores-may-sleep", "--set", "remap.latency=\"25 ms\"",
                                      "--set", "remap.lead=\"3 ms\""});
    if (live.exit_code == 2) return false;  // not everything can run live
    law.shows(live.text());
    MUST(live.signal == 0);
    MUST(live.exit_code <= 3);
    if (live.exit_code <= 1) {
      const Ended replay = bench.program({"replay", "live.inputs", "--out", "replayed"});
      law.shows(replay.text());
      MUST(replay.exit_code <= 1);
      const Json a = Json::parse(content_of(bench.path() + "/live/summary.json"), nullptr, false),
                 b = Json::parse(content_of(bench.path() + "/replayed/summary.json"), nullptr, false);
      if (!MUST(a.is_object())) return true;
      if (!MUST(b.is_object())) return true;
      MUST(a.at("trace_hash") == b.at("trace_hash"));
    }
    fs::remove(bench.path() + "/live.inputs");
    return live.exit_code <= 1;
  });
}
