// What must hold for every scenario, whatever keys meet in it (docs/internals/testing.md has the laws and their reasons).
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <regex>

#include "catch.h"
#include "evenstep/harness/strategy_run.h"
#include "law_bench.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// The rows of all segments but the last one, which the end of a run cuts.
std::string whole_segments(const std::string& timing) {
  const std::size_t last_row = timing.rfind('\n', timing.size() - 2) + 1;
  const std::string last = timing.substr(last_row, timing.find(',', last_row) + 1 - last_row);  // "90,"
  return timing.substr(0, timing.find('\n' + last) + 1);
}

/// Whether the ring of samples and that of forces of any device overran in a run of this plan.
std::pair<bool, bool> overruns_of(const Scenario& scenario, const StrategyPlan& plan) {
  std::pair<bool, bool> overran{false, false};
  for (const DeviceRecord& device : run_strategy(scenario, plan, {}).devices) {
    for (const StepSample& step : device.steps) overran.first |= step.read == StepRead::overrun;
    overran.second |= device.flow->ticks_overrun > 0;
  }
  return overran;
}

}  // namespace

TEST_CASE("Nine of ten drawn scenarios are valid") {
  const Bench bench;
  const auto [first, end] = seeds(100);
  std::uint64_t valid = 0;
  for (std::uint64_t seed = first; seed < end; ++seed) valid += bench.draw(seed).is_valid;
  INFO("seeds " << first << " to " << end - 1);
  CHECK(10 * (valid + 2) >= 9 * (end - first));  // two more may be chance: under sanitizers only five are drawn
}

TEST_CASE("check and run agree on what is valid, and end as documented, the same way twice") {
  judge_drawn(30, [](Law& law, GeneratedScenario drawn) {
    const Bench::Run run = law.bench.run(drawn.toml, "run", {"--repeat", "--threads", law.seed % 2 == 0 ? "1" : "3"});
    const Ended check = law.bench.program({"check", "scenario.toml"});
    law.shows("run: " + run.ended.text() + "check: " + check.text());
    MUST(run.ended.signal == 0);
    MUST(run.ended.exit_code != 4);
    MUST(run.ended.output.find("bad_alloc") == std::string::npos);
    MUST(check.exit_code >= 0 && check.exit_code <= 2);
    // Of a sweep, check asks for expectations, and a run takes no notice of it.
    if (!drawn.root.has("sweep")) MUST((check.exit_code == 2) == (run.ended.exit_code == 2));
    return true;
  });
}

TEST_CASE("What is not repaired is refused with its place, or runs") {
  const Bench bench;
  const auto [first, end] = seeds(60);
  for (std::uint64_t seed = first; seed < end; ++seed) {
    const GeneratedScenario drawn = ScenarioGenerator(seed, bench.path(), own_parts::registry()).unrepaired(kRichness);
    INFO("EVENSTEP_SEED=" << seed << '\n' << drawn.toml);
    std::ofstream(bench.scenario()) << drawn.toml;
    const Ended check = bench.program({"check", "scenario.toml"});
    INFO(check.text());
    CHECK(check.signal == 0);
    CHECK((check.exit_code != 2 || std::regex_search(check.output, std::regex(":[0-9]+:[0-9]+: error"))));
  }
}

TEST_CASE("No ring overruns, and what is predicted is what is counted, for every device and strategy") {
  judge_drawn(30, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (drawn.root.has("case") || drawn.root.has("expect_stop")) return false;
    const Bench::Run run = bench.run(drawn.toml, "run");
    if (run.ended.exit_code > 1 || !run.summary.is_object()) return false;
    const bool gated = drawn.toml.find("\"gate\"") != std::string::npos;
    if (loses(drawn.toml)) return false;
    const bool exact = !ages_vary(drawn.toml) && !stamped(drawn.toml);
    bool is_judged = false;
    for (const auto& [signal, metrics] : run.summary.at("metrics").items()) {
      // The reference has no sizing of its own: with a latency that is too small its forces are late, which nobody predicts.
      if (signal.find(".buffers.") == std::string::npos || signal.ends_with(".ideal")) continue;
      law.shows(signal + ' ' + metrics.dump());
      if (metrics.contains("overruns")) MUST(metrics.at("overruns") == 0);
      if (!metrics.contains("predicted_late_forces")) continue;
      is_judged = true;
      // Of a strategy without a map nothing is sized: with an age its first steps come before the first sample.
      const bool sized = metrics.at("latency_any_phase") != 0;
      if (!gated && sized) MUST(metrics.at("predicted_interaction_underruns") >= metrics.at("interaction_underruns"));
      if (!gated && exact) MUST(metrics.at("predicted_interaction_underruns") == metrics.at("interaction_underruns"));
      if (!gated || exact) MUST(metrics.at("predicted_late_forces") == metrics.at("force_underruns"));
    }
    return is_judged;
  });
}

TEST_CASE("Two entries less in either ring, and it overruns on some schedule") {
  // Of the two, one is for what may arrive while a read is under way, which nothing does on the virtual clock.
  std::int64_t hand = 0, force = 0;
  judge_drawn(30, [&](Law& law, GeneratedScenario drawn) {
    if (drawn.root.has("case")) return false;
    std::ofstream(law.bench.scenario()) << drawn.toml;
    const ReadResult scenario = read_scenario(law.bench.scenario(), {.registry = law.bench.registry()});
    if (!scenario) return false;
    enum { kJudged = 1, kOverran = 2, kHand = 4, kForce = 8 };
    const bool may_overrun = loses(drawn.toml);
    const std::optional<int> seen = in_own_process([&] {
      int bits = 0;
      for (StrategyPlan& plan : evenstep::plan(*scenario)) {
        if (!is_remap(plan.kind)) continue;
        const auto [hand_overran, force_overran] = overruns_of(*scenario, plan);
        plan.interaction_capacity -= 2;
        plan.force_capacity -= 2;
        const auto [less_hand, less_force] = overruns_of(*scenario, plan);
        bits |= kJudged | (!may_overrun && (hand_overran || force_overran) ? kOverran : 0) | (less_hand ? kHand : 0) |
                (less_force ? kForce : 0);
      }
      return bits;
    });
    if (!seen || !(*seen & kJudged)) return false;
    MUST(!(*seen & kOverran));
    hand += (*seen & kHand) != 0;
    force += (*seen & kForce) != 0;
    return true;
  });
  std::cout << hand << " and " << force << " scenarios overran\n";
  const auto [first, end] = seeds(30);
  CHECK((hand > 0 || kSanitized || end - first == 1));
  CHECK((force > 0 || kSanitized || end - first == 1));
}

TEST_CASE("A run's timing.csv, played back, is the same schedule") {
  judge_drawn(30, [](Law& law, GeneratedScenario drawn) {
    const Bench& bench = law.bench;
    if (!drawn.root.has("timing")) return false;
    const Bench::Run run = bench.run(drawn.toml, "run");
    const std::string timing = content_of(bench.path() + "/run/timing.csv");
    if (run.ended.exit_code > 1 || std::count(timing.begin(), timing.end(), '\n') < 3) return false;
    std::ofstream(bench.path() + "/first.csv") << timing;
    const Bench::Run again = bench.run(
        "format = 1\n[timing]\ntrace = \"first.csv\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"left\"\n", "again");
    law.shows(again.ended.text());
    MUST(again.ended.exit_code == 0);
    MUST(whole_segments(content_of(bench.path() + "/again/timing.csv")) == whole_segments(timing));
    return true;
  });
}

TEST_CASE(
    "What drawn scenarios have found stays mended: nothing is missing, nothing overruns, constant timing is straight") {
  constexpr const char* kTiming =
      "format = 1\n[run]\nduration = \"3 s\"\nwarmup = \"8 segments\"\n[scene]\nkind = \"spring\"\n";
  constexpr const char* kJitter =
      "[timing]\nsegment = \"33.3 ms\"\nvisualization = \"11.1 ms\"\nsteps = 15\n"
      "jitter = { visualization = \"uniform 5 %\", step = \"uniform 2 %\" }\n";
  constexpr const char* kMoves =
      "motion = { kind = \"constant-velocity\", velocity = [\"0.05 m/s\", \"0 m/s\", \"0 m/s\"] }\n";
  constexpr const char* kGate = "underrun = { interaction = \"gate\" }\n";
  const std::string moving = std::string("[[device]]\nname = \"d0\"\n") + kMoves;
  struct {
    const char* what;
    std::string toml;
  } const rows[] = {
      {"an age at one phase", std::string(kJitter) + moving +
                                  "phase = \"0.3 ms\"\nreport_age = \"0.5 ms\"\n[remap]\nlatency = \"minimal-this-phase\"\n"
                                  "lead = \"minimal-this-phase\"\n"},
      {"a slower clock",
       std::string(kJitter) + moving + "rate = \"1234.5 Hz\"\nphase = \"0.3 ms\"\nclock_rate_error = \"-900 ppm\"\n"},
      // A tick without a report gives the last position again: no more latency is needed.
      {"a slower clock, samples by their arrival",
       "[timing]\nsegment = \"20 ms\"\nvisualization = \"2 ms\"\nsteps = 18\n" + moving +
           "clock_rate_error = \"-900 ppm\"\nsample_time = \"arrival\"\n[remap]\nlead = \"minimal-this-phase\"\n"},
      {"a gate and two rates", "[timing]\nsegment = \"11.1 ms\"\nvisualization = \"2.9692 ms\"\nsteps = 40\n" + moving +
                                   "rate = \"125 Hz\"\nphase = \"5.313 ms\"\n[[device]]\nname = \"d1\"\n" + kMoves +
                                   "[remap]\n" + kGate},
      {"a gate and an age", "[timing]\nsegment = \"10 ms\"\nvisualization = \"1.4978 ms\"\nsteps = 1\n" + moving +
                                "rate = \"1234.5 Hz\"\nphase = \"0.8012 ms\"\nreport_age = \"3 ms\"\n[remap]\n" +
                                "lead = \"6.269 ms\"\nlatency = \"minimal-this-phase\"\n" + kGate},
  };
  const Bench bench;
  for (const auto& row : rows) {
    const Bench::Run run = bench.run(kTiming + row.toml, "run");
    INFO(row.what << '\n' << run.ended.text());
    REQUIRE(run.ended.exit_code == 0);
    for (const auto& [signal, metrics] : run.summary.at("metrics").items()) {
      INFO(signal << ' ' << metrics.dump());
      if (signal.find(".buffers.") != std::string::npos) {
        CHECK(metrics.at("overruns") == 0);
        CHECK(metrics.at("interaction_underruns") == 0);
        CHECK(metrics.at("force_underruns") == 0);
      }
      if (row.toml.find("gate") != std::string::npos && signal.ends_with(".interaction.phase_locked"))
        CHECK(metrics.at("velocity_jump").get<double>() < 1e-7);  // m: two stamps of a microsecond, at 0.05 m/s
    }
  }
}

TEST_CASE(
    "A drawing that is longer than its segment, or was dropped, is played back as it ran, and a governor's schedule is "
    "shrunk") {
  const std::string head =
      "format = 1\n[run]\nduration = \"1.5 s\"\n[scene]\nkind = \"spring\"\n[[device]]\nname = \"d0\"\n";
  const Bench bench;
  for (const char* const timing :
       {"[timing]\nsegment = \"16.7 ms\"\nvisualization = \"3.711 ms\"\norder = \"concurrent\"\nsteps = 1\npaced = true\n"
        "hitch = { every = \"0.5 s\", visualization = \"40 ms\" }\n",
        "[timing]\nsegment = \"20 ms\"\nvisualization = \"9.6945 ms\"\norder = \"concurrent\"\nsteps = 8\npaced = true\n"
        "jitter = { visualization = \"uniform 10 %\", step = \"uniform 10 %\" }\ndropped_visualization = \"30 %\"\n"}) {
    const Bench::Run run = bench.run(head + timing, "run");
    INFO(timing << run.ended.text());
    REQUIRE(run.ended.exit_code == 0);
    const std::string csv = content_of(bench.path() + "/run/timing.csv");
    std::ofstream(bench.path() + "/first.csv") << csv;
    const Bench::Run again = bench.run(
        head.substr(0, head.find("[run]")) + head.substr(head.find("[scene]")) + "[timing]\ntrace = \"first.csv\"\n",
        "again");
    INFO(again.ended.text());
    REQUIRE(again.ended.exit_code == 0);
    CHECK(whole_segments(content_of(bench.path() + "/again/timing.csv")) == whole_segments(csv));
    for (const char* const strategy : {"paper", "phase_locked"}) {
      const std::string signal = std::string("d0.buffers.") + strategy;
      for (const char* const metric : {"lead", "latency"})
        CHECK(again.summary.at("metrics").at(signal).at(metric) == run.summary.at("metrics").at(signal).at(metric));
    }
  }
  std::ofstream(bench.scenario())
      << head +
             "[remap]\nlatency = \"8 ms\"\n[timing]\nsegment = \"33.3 ms\"\n"
             "visualization = \"11.1 ms\"\nsteps = 1\n"
             "jitter = { visualization = \"lognormal 30 %\", step = \"lognormal 10 %\" }\n"
             "governor = { split = 3, budget = \"2 ms\", over_budget = \"skip\" }\n"
             "[[expect]]\nsignal = \"*.buffers.phase_locked\"\nmetric = \"underruns\"\nmax = 0\n";
  const Ended shrunk = bench.program({"shrink", "scenario.toml", "--out", "shrunk"});
  INFO(shrunk.text());
  CHECK(shrunk.exit_code == 0);
}
