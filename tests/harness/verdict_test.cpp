// The verdict of a whole run: pass, none, degraded, fail or error; and what is known of it before the run.

#include "evenstep/harness/foresee.h"

#include <fmt/format.h>

#include <cmath>

#include "evenstep/harness/suffered.h"
#include "evenstep/text/quantity.h"
#include "scenarios.h"
#include "src/judge.h"

using namespace evenstep;
using namespace evenstep::test;
using Verdict = ExpectationResult::Verdict;

namespace {

RunOutcome outcome_of(const std::string& expectations, const RunOptions& options = {}) {
  return run_scenario(
      read("paper/figure-1-spring.toml", {"run.duration=\"0.4 s\"", "run.warmup=\"0.2 s\"", "remap.latency=\"60 ms\"",
                                          "remap.lead=\"20 ms\"", "expect=[" + expectations + "]"}),
      options);
}

const std::string kHolds = "{ signal = \"run\", metric = \"strategies\", equals = 4 }";
const std::string kHoldsOnWall = "{ signal = \"run\", metric = \"strategies\", equals = 4, clock = \"wall\" }";
const std::string kFailsOnWall = "{ signal = \"run\", metric = \"strategies\", equals = 5, clock = \"wall\" }";
const std::string kFailsOnVirtual = "{ signal = \"run\", metric = \"strategies\", equals = 5, clock = \"virtual\" }";

}  // namespace

TEST_CASE("what a run suffered is said unless an expectation that was judged asks about it") {
  RunOutcome outcome;
  outcome.record.strategies.resize(2);
  for (const int i : {0, 1}) {
    outcome.record.strategies[static_cast<std::size_t>(i)].name = i == 0 ? "paper" : "direct";
    outcome.record.strategies[static_cast<std::size_t>(i)].devices.resize(1);
    outcome.record.strategies[static_cast<std::size_t>(i)].devices[0].name = "left";
  }
  CHECK(suffered_lines(outcome).empty());
  outcome.metrics["left.interaction.paper"] = {{"judged", 50}, {"underruns", 0}};
  outcome.metrics["left.force.paper"] = {{"underruns", 4}, {"lost", 1}};
  outcome.metrics["left.force.direct"] = {{"lost", 1}};
  outcome.metrics["solver.paper"] = {{"non_finite", 3}};
  const std::string late = "went wrong   left.paper: 4 of 50 forces late, 1 reports lost; nothing asserts this\n",
                    lost = "went wrong   left.paper, left.direct: 1 reports lost; nothing asserts this\n",
                    direct = "went wrong   left.direct: 1 reports lost; nothing asserts this\n",
                    solver = "went wrong   paper: 3 values not finite; nothing asserts this\n";
  CHECK(suffered_lines(outcome) == late + solver + direct);
  const auto with = [&](const char* signal, const char* metric, Verdict verdict, const char* pattern = "") {
    RunOutcome asked = outcome;
    asked.results = {{.signal = signal, .metric = metric, .verdict = verdict, .pattern = pattern}};
    return suffered_lines(asked);
  };
  // By the metric itself, by another one that asks the same, by the device's buffers, by a pattern; also by one that fails.
  CHECK(with("left.force.paper", "underruns", Verdict::pass) == lost + solver);
  CHECK(with("left.force.paper", "underrun_rate", Verdict::fail) == lost + solver);
  CHECK(with("left.buffers.paper", "underruns", Verdict::pass) == lost + solver);
  CHECK(with("left.force.direct", "underruns", Verdict::pass, "*.force.*") == lost + solver);
  CHECK(with("solver.paper", "non_finite", Verdict::error) == late + direct);
  // Not by one that is for the other clock, nor by one about something else.
  CHECK(with("left.force.paper", "underruns", Verdict::skipped) == late + solver + direct);
  CHECK(with("left.interaction.paper", "underruns", Verdict::pass) == late + solver + direct);
  CHECK(with("left.force.paper", "jump_max", Verdict::pass) == late + solver + direct);
}

TEST_CASE("a scene that moves faster than real time is said to suffer it unless that is asserted, and a spring is not") {
  const auto said = [](const std::string& file, const std::string& expect) {
    return suffered_lines(run_scenario(
        read(file,
             {"run.duration=\"0.4 s\"", "run.warmup=\"0.2 s\"", "run.strategies=[\"direct\"]", "scene.step_size=\"90 Hz\"",
              "expect=[{ signal = \"run\", metric = \"strategies\", equals = 1 }" + expect + "]"}),
        {}));
  };
  // 450 steps a second, each of 1/90 s.
  CHECK_THAT(said("closed-loop/tissue-ripple.toml", ""),
             Catch::StartsWith("went wrong   direct: simulated time passes 5.") && Catch::Contains("nothing asserts this"));
  CHECK(
      said("closed-loop/tissue-ripple.toml", ", { signal = \"solver.direct\", metric = \"simulated_per_real\", min = 4.9 }")
          .empty());
  CHECK(said("paper/figure-1-spring.toml", "").empty());
}

TEST_CASE("a run that asserts nothing has no verdict, and exits with 1 unless that is allowed") {
  RunOptions allowed;
  allowed.allow_no_expectations = true;
  for (const std::string& nothing : {std::string(), kHoldsOnWall}) {
    const RunOutcome outcome = outcome_of(nothing);
    CHECK(outcome.verdict == RunVerdict::none);
    CHECK(outcome.exit == ExitCode::expectation_failed);
    CHECK(outcome_of(nothing, allowed).verdict == RunVerdict::none);
    CHECK(outcome_of(nothing, allowed).exit == ExitCode::pass);
  }
  CHECK(outcome_of(kHolds).verdict == RunVerdict::pass);
  CHECK(outcome_of(kHolds).exit == ExitCode::pass);
}

TEST_CASE("a time that equals its limit holds, in every unit, and one ns beyond it fails") {
  const auto verdicts = [](const std::string& latency, const std::vector<std::string>& limits) {
    std::string expectations;
    for (const std::string& limit : limits)
      expectations += "{ signal = \"left.buffers.phase_locked\", metric = \"latency\", " + limit + " },";
    const RunOutcome outcome = run_scenario(
        read("paper/figure-1-spring.toml", {"run.duration=\"0.4 s\"", "run.warmup=\"0.2 s\"",
                                            "remap.latency=\"" + latency + "\"", "expect=[" + expectations + "]"}),
        {});
    std::vector<Verdict> out;
    for (const ExpectationResult& result : outcome.results) out.push_back(result.verdict);
    return out;
  };
  CHECK(verdicts("43 ms", {"equals = \"43 ms\"", "equals = \"0.043 s\"", "equals = \"43000 us\"", "max = \"43 ms\"",
                           "min = \"43 ms\", max = \"0.043 s\""}) == std::vector<Verdict>(5, Verdict::pass));
  CHECK(verdicts("12.03 ms", {"equals = \"12.03 ms\"", "max = \"12.03 ms\"", "min = \"12.03 ms\""}) ==
        std::vector<Verdict>(3, Verdict::pass));
  CHECK(verdicts("43 ms", {"equals = \"43.000001 ms\"", "max = \"42.999999 ms\"", "min = \"43.000001 ms\""}) ==
        std::vector<Verdict>(3, Verdict::fail));
}

TEST_CASE("of the signals that a * matches, one a rounding above the limit fails, beside one that equals it, 400 limits") {
  int failed = 0;
  for (int k = 0; k < 200; ++k) {
    const std::string limit = fmt::format("{}.{:03} ms", 12 + k / 7, 3 * k + 1);
    const Scenario scenario =
        read("paper/figure-1-spring.toml",
             {"expect=[{ signal = \"left.buffers.*\", metric = \"latency\", max = \"" + limit + "\" }]"});
    const double equal_s = seconds(*parse_duration(limit)), above_s = std::nextafter(equal_s, 1.0);
    for (const bool first : {false, true}) {
      const Metrics metrics{{"left.buffers.paper", {{"latency", first ? above_s : equal_s}}},
                            {"left.buffers.phase_locked", {{"latency", first ? equal_s : above_s}}}};
      failed += internal::judge(scenario, RunRecord{}, metrics).at(0).verdict == Verdict::fail;
    }
  }
  CHECK(failed == 400);
}

TEST_CASE("an expectation for the other clock is skipped, in its place") {
  const RunOutcome outcome = outcome_of(kFailsOnWall + ", " + kHolds);
  CHECK(outcome.exit == ExitCode::pass);
  REQUIRE(outcome.results.size() == 2);
  CHECK(outcome.results[0].verdict == Verdict::skipped);
  CHECK(*outcome.results[0].max == 5);
  CHECK(outcome.results[1].verdict == Verdict::pass);
  CHECK(outcome_of(kFailsOnVirtual).exit == ExitCode::expectation_failed);
}

TEST_CASE("what fails only because the machine was late is degraded, and exits with 1 unless that is allowed") {
  RunOptions options;
  options.clock = ClockKind::wall;
  const RunOutcome outcome = outcome_of(kFailsOnWall + ", " + kHolds + ", " + kFailsOnVirtual, options);
  INFO(outcome.failure);
  CHECK(outcome.verdict == RunVerdict::degraded);
  CHECK(outcome.exit == ExitCode::expectation_failed);
  CHECK(outcome.results.at(0).verdict == Verdict::degraded);
  CHECK(outcome.results.at(2).verdict == Verdict::skipped);
  options.allow_degraded = true;
  CHECK(outcome_of(kFailsOnWall, options).exit == ExitCode::pass);
  // A failure stays a failure.
  const RunOutcome failed =
      outcome_of(kFailsOnWall + ", { signal = \"run\", metric = \"strategies\", equals = 6 }", options);
  CHECK(failed.verdict == RunVerdict::fail);
  CHECK(failed.exit == ExitCode::expectation_failed);
}

TEST_CASE("on a wall clock the counts add up on any machine: ticks run and missed, lateness of the live ticks alone") {
  RunOptions options;
  options.clock = ClockKind::wall;
  const RunOutcome outcome = outcome_of(kHolds, options);
  INFO(outcome.failure << outcome.repeat_difference);
  REQUIRE(outcome.exit == ExitCode::pass);
  CHECK(outcome.record.live == "phase_locked");
  const Rows<TickRow>& ticks = strategy(outcome.record, "phase_locked").devices[0].ticks;
  const auto& values = outcome.metrics.at("events.device.tick");
  CHECK(values.at("ticks_run") == static_cast<double>(ticks.size()));
  // One tick is due each millisecond from 0 to the end of the run, however late the machine was at its begin or its end.
  const RealTime end = std::max(outcome.record.nominal.end, ticks.back().at + Duration{1});
  const std::int64_t due = (end.ns + 999'999) / 1'000'000;
  CHECK(values.at("ticks_run") + values.at("deadline_misses") == static_cast<double>(due));
  Duration most;
  for (const TickRow& tick : ticks) most = std::max(most, tick.lateness);
  CHECK(values.at("lateness_max") == Approx(seconds(most)).epsilon(1e-12));
  // Ticks are at least a period apart, so every tick in between either ran or is counted as missed.
  CHECK(values.at("lateness_p50") > 0);
}

TEST_CASE("a run that is interrupted is measured up to there") {
  std::atomic<bool> interrupted{false};
  RunOptions options;
  options.clock = ClockKind::wall;
  options.control.interrupted = &interrupted;
  options.control.progress = [&](const std::string&, double fraction) { interrupted = fraction > 0.05; };
  const RunOutcome outcome =
      run_scenario(read("live/figure-1-spring.toml", {"run.duration=\"30 s\"", "run.warmup=\"0.2 s\""}), options);
  CHECK(outcome.exit == ExitCode::interrupted);
  REQUIRE(outcome.record.strategies.size() == 1);
  CHECK(outcome.record.strategies[0].interrupted);
  const double judged_s = outcome.metrics.at("run").at("judged_s");
  CHECK(judged_s > 1);
  CHECK(judged_s < 25);
  CHECK(outcome.cpu_seconds > 0);
}

TEST_CASE("a late force that is foreseen fails in the run, at the same steps, and with the latency that would do it holds",
          "[sweep]") {
  int foreseen = 0, held = 0;
  for (const char* jitter : {"0.001 %", "5 %", "10 %", "20 %"}) {
    for (int latency_ms = 11; latency_ms <= 26; latency_ms += 3) {
      for (const char* signal : {"left.force.phase_locked", "left.buffers.paper", "left.interaction.phase_locked"}) {
        std::vector<std::string> set{
            "run.duration=\"1.2 s\"",
            "run.strategies=[\"paper\", \"phase_locked\"]",
            "remap.lead=\"0.7 ms\"",
            fmt::format("remap.latency=\"{} ms\"", latency_ms),
            fmt::format("timing.jitter={{ visualization = \"lognormal {0}\", step = \"lognormal {0}\" }}", jitter),
            fmt::format("expect=[{{ signal = \"{}\", metric = \"underruns\", equals = 0 }}]", signal)};
        const Scenario scenario = read("paper/figure-1-spring.toml", set);
        const std::vector<ExpectationResult> failures = foresee_failures(scenario, plan(scenario));
        const RunOutcome outcome = run_scenario(scenario, {});
        INFO(jitter << " " << latency_ms << " ms " << signal);
        REQUIRE(outcome.results.size() == 1);
        REQUIRE((failures.size() == 1) == (outcome.exit == ExitCode::expectation_failed));
        ++(failures.empty() ? held : foreseen);
        if (failures.empty()) continue;
        CHECK(*failures[0].value == *outcome.results[0].value);
        CHECK(failures[0].where == outcome.results[0].where);
        // The values that "would do" according to the message do make the run pass.
        const std::string& where = failures[0].where;
        const std::size_t latency = where.rfind("latency "), lead = where.rfind("lead "), ms = where.rfind(" ms would do");
        REQUIRE(latency < ms);
        set.push_back("remap.latency=\"" + where.substr(latency + 8, ms - latency - 8) + " ms\"");
        if (lead < latency)
          set.push_back("remap.lead=\"" + where.substr(lead + 5, where.find(" ms", lead) - lead - 5) + " ms\"");
        CHECK(run_scenario(read("paper/figure-1-spring.toml", set), {}).exit == ExitCode::pass);
      }
    }
  }
  CHECK(foreseen > 20);
  CHECK(held > 5);
}

TEST_CASE("latencies, leads and rings that cannot fit are foreseen, what the plan does not know is not judged") {
  const auto failures = [](const std::string& expectation, std::vector<std::string> more = {}) {
    more.insert(more.end(), {"run.duration=\"0.6 s\"", "expect=[" + expectation + "]"});
    const Scenario scenario = read("paper/figure-1-spring.toml", more);
    return foresee_failures(scenario, plan(scenario)).size();
  };
  const std::string buffers = "signal = \"left.buffers.phase_locked\", ";
  CHECK(failures("{ " + buffers + "metric = \"latency\", max = \"15 ms\" }") == 1);
  CHECK(failures("{ " + buffers + "metric = \"latency\", max = \"15.1 ms\" }") == 0);
  CHECK(failures("{ signal = \"left.buffers.*\", metric = \"latency_any_phase\", max = \"15 ms\" }") == 1);
  CHECK(failures("{ " + buffers + "metric = \"latency\", max = \"15.1 ms\", expect_fail = true }") == 1);
  CHECK(failures("{ " + buffers + "metric = \"latency\", max = \"15 ms\", clock = \"wall\" }") == 0);
  CHECK(failures("{ signal = \"left.interaction.direct\", metric = \"velocity_jump\", max = \"1 step\" }") == 0);
  CHECK(failures("{ signal = \"*.*.*\", metric = \"underruns\", max = 0, expect_fail = true }",
                 {"remap.latency=\"12 ms\""}) == 0);
  CHECK(failures("{ " + buffers + "metric = \"latency\", max = \"15 ms\" }", {"expect_stop={ reason = \"diverged\" }"}) ==
        0);
}
