// Expectations: what passes, what fails, and what is an error instead of a pass.

#include <cstdio>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::vector<std::string> kShort{"run.duration=\"0.6 s\"", "run.strategies=[\"direct\", \"phase_locked\"]"};

std::vector<std::string> expecting(const std::string& expectation) {
  std::vector<std::string> set = kShort;
  set.push_back("expect=[" + expectation + "]");
  return set;
}
RunOutcome outcome_of(const std::string& expectation) {
  return run_scenario(read("paper/figure-1-spring.toml", expecting(expectation)), {});
}

}  // namespace

TEST_CASE("an expectation that holds passes, one that does not fails, and expect_fail turns it round") {
  const std::string jump = "signal = \"left.interaction.direct\", metric = \"velocity_jump\"";
  CHECK(outcome_of("{ " + jump + ", min = \"4 step\" }").exit == ExitCode::pass);
  CHECK(outcome_of("{ " + jump + ", min = \"7 step\" }").exit == ExitCode::expectation_failed);
  CHECK(outcome_of("{ " + jump + ", max = \"1e-6 step\" }").exit == ExitCode::expectation_failed);
  CHECK(outcome_of("{ " + jump + ", max = \"1e-6 step\", expect_fail = true }").exit == ExitCode::pass);
  CHECK(outcome_of("{ " + jump + ", min = \"4 step\", expect_fail = true }").exit == ExitCode::expectation_failed);
}

TEST_CASE("limits in other units judge the same value") {
  const std::string jump = "signal = \"left.interaction.direct\", metric = \"velocity_jump\"";
  const RunOutcome in_steps = outcome_of("{ " + jump + ", min = \"4 step\" }");
  const RunOutcome in_mm = outcome_of("{ " + jump + ", min = \"0.8 mm\" }");
  const RunOutcome mixed = outcome_of("{ " + jump + ", min = \"0.8 mm\", max = \"6 step\" }");
  REQUIRE(in_steps.results[0].value);
  REQUIRE(in_mm.results[0].value);
  CHECK(*in_mm.results[0].value ==
        Approx(*in_steps.results[0].value * 100.0 / 450).epsilon(1e-12));  // step = 0.1 m/s / 450 Hz
  CHECK(*mixed.results[0].max == 6);                                       // shown in the unit of the upper limit
  CHECK(*mixed.results[0].min == Approx(0.8 * 450 / 100.0).epsilon(1e-12));
  CHECK(mixed.exit == ExitCode::pass);
}

TEST_CASE("a star is judged by the worst of the signals it matches") {
  const RunOutcome outcome =
      outcome_of("{ signal = \"left.interaction.*\", metric = \"velocity_jump\", max = \"1e-6 step\" }");
  CHECK(outcome.exit == ExitCode::expectation_failed);
  CHECK(outcome.results[0].signal == "left.interaction.direct");
}

TEST_CASE("under a lower limit the worst of a star's signals is the smallest: one that is too small fails it") {
  const RunOutcome outcome = outcome_of("{ signal = \"left.interaction.*\", metric = \"velocity_jump\", min = \"4 step\" }");
  CHECK(outcome.exit == ExitCode::expectation_failed);  // direct jumps by 5.4 steps, phase_locked by none
  CHECK(outcome.results[0].signal == "left.interaction.phase_locked");
  // With two limits, the worst signal is the one that comes nearest to a limit.
  const RunOutcome both =
      outcome_of("{ signal = \"left.interaction.*\", metric = \"velocity_jump\", min = \"1e-9 step\", max = \"5.5 step\" }");
  CHECK(both.exit == ExitCode::pass);
  CHECK(both.results[0].signal == "left.interaction.direct");
}

TEST_CASE("a signal that a star matches and that could have the metric is an error if it has no value") {
  // Segments of one second: a map acquires until it has seen a complete one, so in this run its steps are not judged.
  const auto judged = [](const std::string& signal) {
    const RunOutcome outcome =
        run_scenario(read("paper/figure-1-spring.toml",
                          {"run.duration=\"0.9 s\"", "run.warmup=\"0 s\"", "run.strategies=[\"direct\", \"paper\"]",
                           "timing.segment=\"1 Hz\"", "timing.steps=450",
                           "expect=[{ signal = \"" + signal + "\", metric = \"back_steps\", max = 1000 }]"}),
                     {});
    INFO(outcome.failure);
    REQUIRE(outcome.results.size() == 1);
    return outcome.results[0];
  };
  CHECK(judged("left.interaction.direct").verdict == ExpectationResult::Verdict::pass);
  CHECK(judged("left.interaction.paper").verdict == ExpectationResult::Verdict::error);
  for (const char* pattern : {"left.interaction.*", "*.interaction.*", "left.*.paper"}) {
    INFO(pattern);
    const ExpectationResult result = judged(pattern);
    CHECK(result.verdict == ExpectationResult::Verdict::error);
    CHECK(result.signal == "left.interaction.paper");
    CHECK_THAT(result.detail, Catch::Contains("no sample was judged") && Catch::Contains(pattern));
  }
}

TEST_CASE("an error under a star is never hidden by a known fault") {
  // direct fails its limit by an infinite factor, as it is expected to; paper has no value.
  const RunOutcome outcome = run_scenario(
      read(
          "paper/figure-1-spring.toml",
          {"run.duration=\"0.9 s\"", "run.warmup=\"0 s\"", "run.strategies=[\"direct\", \"paper\"]",
           "timing.segment=\"1 Hz\"", "timing.steps=450",
           "expect=[{ signal = \"left.interaction.*\", metric = \"latency_max\", min = \"1e300 s\", expect_fail = true }]"}),
      {});
  REQUIRE(outcome.results.size() == 1);
  CHECK(outcome.results[0].verdict == ExpectationResult::Verdict::error);
}

TEST_CASE("a rate of underruns with a confidence is an error for a strategy without a map, also under a star") {
  const auto judged = [](const std::string& signal) {
    return outcome_of("{ signal = \"" + signal + "\", metric = \"underrun_rate\", max = 0.5, confidence = \"95 %\" }")
        .results.at(0);
  };
  CHECK(judged("left.buffers.phase_locked").verdict == ExpectationResult::Verdict::pass);
  for (const char* signal : {"left.buffers.direct", "left.buffers.*"}) {
    INFO(signal);
    CHECK(judged(signal).verdict == ExpectationResult::Verdict::error);
    CHECK(judged(signal).signal == "left.buffers.direct");
  }
}

TEST_CASE("the result of a star has the signal that was judged and the one that was written") {
  const RunOutcome outcome =
      outcome_of("{ signal = \"left.interaction.*\", metric = \"velocity_jump\", max = \"1e-6 step\" }");
  CHECK(outcome.results.at(0).signal == "left.interaction.direct");
  CHECK(outcome.results.at(0).pattern == "left.interaction.*");
}

namespace {

/// 10 % jitter, with a lead and a latency for which either nothing is late or everything is.
ExpectationResult judged_rate(const std::string& expectation, const std::string& latency) {
  const RunOutcome outcome = run_scenario(
      read("paper/figure-1-spring-hold.toml",
           {"run.duration=\"0.7 s\"", "run.strategies=[\"phase_locked\"]", "remap.lead=\"9 ms\"",
            "remap.latency=\"" + latency + "\"",
            "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }",
            "expect=[{ signal = \"left.buffers.phase_locked\", metric = \"underrun_rate\", " + expectation + " }]"}),
      {});
  INFO(outcome.failure);
  REQUIRE(outcome.results.size() == 1);
  REQUIRE(outcome.results[0].value);
  return outcome.results[0];
}

}  // namespace

TEST_CASE("a rate of underruns is judged in the unit of its limit") {
  using Verdict = ExpectationResult::Verdict;
  for (const char* latency : {"60 ms", "9 ms"}) {
    const ExpectationResult share = judged_rate("max = 0.02, confidence = \"95 %\", seeds = 30", latency);
    const ExpectationResult percent = judged_rate("max = \"2 %\", confidence = \"95 %\", seeds = 30", latency);
    INFO(latency << ": " << share.detail);
    CHECK(*percent.value == Approx(100 * *share.value).epsilon(1e-12));
    CHECK(*percent.max == 2);
    CHECK(percent.verdict == share.verdict);
    CHECK(share.verdict == (std::string(latency) == "60 ms" ? Verdict::pass : Verdict::fail));
  }
}

TEST_CASE("as many seeds are run as a clean record needs to pass") {
  std::int64_t uneven = 0;
  for (const char* most : {"2 %", "1.7 %", "1.3 %", "1 %"}) {
    const ExpectationResult result = judged_rate(std::string("max = \"") + most + "\", confidence = \"95 %\"", "60 ms");
    INFO(most << ": " << result.detail);
    CHECK(result.verdict == ExpectationResult::Verdict::pass);
    CHECK(*result.value <= *result.max);
    long long hit = 0, segments = 0, seeds = 0, needed = 0;
    REQUIRE(std::sscanf(result.detail.c_str(), "%lld of %lld segments in %lld seeds; %lld clean ones", &hit, &segments,
                        &seeds, &needed) == 4);
    CHECK(hit == 0);
    CHECK(segments >= needed);
    CHECK((seeds - 1) * (segments / seeds) < needed);  // no more seeds than needed, of as many segments as the first has
    uneven += segments > needed;
  }
  CHECK(uneven > 0);  // otherwise rounding to whole seeds was never tested
}

TEST_CASE("an unknown metric, or the unit step without a speed, is a scenario error before anything runs") {
  const RunOutcome unknown =
      outcome_of("{ signal = \"left.interaction.direct\", metric = \"velocity_jmp\", max = \"1 step\" }");
  CHECK(unknown.exit == ExitCode::usage);
  REQUIRE(unknown.errors.size() == 1);
  CHECK_THAT(unknown.errors[0].message, Catch::Contains("velocity_jmp") && Catch::Contains("velocity_jump"));
  CHECK(unknown.record.strategies.empty());

  std::vector<std::string> set =
      expecting("{ signal = \"left.interaction.direct\", metric = \"velocity_jump\", max = \"1 step\" }");
  set.push_back("device.left.motion={ kind = \"sine\", amplitude = [\"5 mm\", \"0 m\", \"0 m\"], frequency = \"2 Hz\" }");
  const RunOutcome no_step = run_scenario(read("paper/figure-1-spring.toml", set), {});
  CHECK(no_step.exit == ExitCode::usage);
  CHECK_THAT(no_step.errors.at(0).message, Catch::Contains("no unit 'step'"));
}

TEST_CASE("energy and ideal twin are computed for the strategies that an expectation asks about, and for no other") {
  std::vector<std::string> set = small_tissue("cpu");
  set.push_back("run.duration=\"0.45 s\"");
  const auto run = [&](const std::string& energy, const std::vector<std::string>& twins) {
    std::vector<std::string> asked = set;
    std::string expect = "expect=[{ signal = \"" + energy + "\", metric = \"energy_growth\", max = 1 }";
    for (const std::string& twin : twins)
      expect += ", { signal = \"" + twin + "\", metric = \"deviation_from_ideal\", max = \"1 N\" }";
    asked.push_back(expect + "]");
    RunOutcome outcome = run_scenario(read("paper/figure-1.toml", asked), {});
    CHECK(outcome.exit == ExitCode::pass);
    return outcome;
  };
  // `ideal` has no twin, so "*.force.*" would be an error.
  const RunOutcome all = run("solver.*", {"*.force.direct", "*.force.paper", "*.force.phase_locked"}),
                   some = run("solver.paper", {"right.force.paper"});
  for (const char* name : {"ideal", "direct", "paper", "phase_locked"}) {
    INFO(name);
    const std::string solver = std::string("solver.") + name, force = std::string("right.force.") + name;
    CHECK(all.metrics.at(solver).count("energy_growth") == 1);
    CHECK(some.metrics.at(solver).count("energy_growth") == (name == std::string("paper")));
    CHECK(all.metrics.at(force).count("deviation_from_ideal") == (name != std::string("ideal")));
    // The run's own `ideal` is the twin of the two strategies that remap. `direct` would need a twin of its own.
    const bool has_twin = name == std::string("paper") || name == std::string("phase_locked");
    CHECK(some.metrics.at(force).count("deviation_from_ideal") == has_twin);
    CHECK(strategy(all.record, name).trace_hash == strategy(some.record, name).trace_hash);
  }
  CHECK(all.metrics.at("solver.paper").at("energy_growth") == some.metrics.at("solver.paper").at("energy_growth"));
  CHECK(all.metrics.at("right.force.paper").at("deviation_from_ideal") ==
        some.metrics.at("right.force.paper").at("deviation_from_ideal"));
}

TEST_CASE("how errors grow is measured if it is asked for, with the twin and the undelayed force that it needs") {
  const auto scenario = [](const std::string& expect) {
    return read("paper/figure-1-spring.toml",
                {"run.strategies=[\"direct\"]", "run.duration=\"1 s\"", "expect=[" + expect + "]"});
  };
  const auto asked = [](const std::string& metric) {
    return "{ signal = \"left.force.direct\", metric = \"" + metric + "\", max = 5 }";
  };
  RunOptions options;
  options.allow_no_expectations = true;
  CHECK(growths_of(run_scenario(scenario(""), options).metrics, "left.force.direct").empty());
  options.growths = true;
  CHECK(growths_of(run_scenario(scenario(""), options).metrics, "left.force.direct").size() == 2);  // of two errors
  for (const char* metric : {"deviation_growth", "error_growth", "deviation_from_ideal_growth", "error_growth_min"}) {
    INFO(metric);
    const RunOutcome outcome = run_scenario(scenario(asked(metric)), {});
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(outcome.metrics.at("left.force.direct").count("deviation_from_ideal") ==
          (metric == std::string("deviation_from_ideal_growth")));
    CHECK(scenario(asked(metric)).needs_undelayed == std::string(metric).starts_with("error_"));
  }
}

TEST_CASE("an expectation that judged no sample is an error, never a pass") {
  std::vector<std::string> set =
      expecting("{ signal = \"left.interaction.phase_locked\", metric = \"velocity_jump\", max = \"1 step\" }");
  set.push_back("run.warmup=\"0.5999 s\"");
  const RunOutcome outcome = run_scenario(read("paper/figure-1-spring.toml", set), {});
  CHECK(outcome.exit == ExitCode::usage);
  CHECK(outcome.results.at(0).verdict == ExpectationResult::Verdict::error);
}

TEST_CASE("a rate of underruns over no segment is an error, never a pass") {
  const RunOutcome outcome = run_scenario(
      read("paper/figure-1-spring-hold.toml",
           {"run.duration=\"0.7 s\"", "run.warmup=\"0.6999 s\"", "run.strategies=[\"phase_locked\"]",
            "remap.latency=\"60 ms\"", "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }",
            "expect=[{ signal = \"left.buffers.phase_locked\", metric = \"underrun_rate\", max = \"2 %\", confidence = \"95 "
            "%\" }]"}),
      {});
  REQUIRE(outcome.results.size() == 1);
  CHECK(outcome.results[0].verdict == ExpectationResult::Verdict::error);
  CHECK_THAT(outcome.results[0].detail, Catch::Contains("no segment is judged"));
  CHECK(outcome.exit == ExitCode::usage);
}
