// Expectations: what passes, what fails, and what is an error instead of a pass.

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

TEST_CASE("an expectation that judged no sample is an error, never a pass") {
  std::vector<std::string> set =
      expecting("{ signal = \"left.interaction.phase_locked\", metric = \"velocity_jump\", max = \"1 step\" }");
  set.push_back("run.warmup=\"0.5999 s\"");
  const RunOutcome outcome = run_scenario(read("paper/figure-1-spring.toml", set), {});
  CHECK(outcome.exit == ExitCode::usage);
  CHECK(outcome.results.at(0).verdict == ExpectationResult::Verdict::error);
}
