// Runs that must stop before their end: unstable steps, divergence, interrupts.

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::vector<std::string> unstable(bool allowed) {
  std::vector<std::string> set = small_tissue("cpu");
  set.push_back("scene.substeps=1");  // 2.22 ms where 0.64 ms is the limit
  set.push_back("expect=[]");
  if (allowed) set.push_back("scene.allow_unstable=true");
  return set;
}

}  // namespace

TEST_CASE("an unstable step size is refused with limit and remedy, and a scenario may expect that") {
  const RunOutcome outcome = run_scenario(read("paper/figure-1.toml", unstable(false)), {});
  CHECK(outcome.exit == ExitCode::run_failed);
  CHECK_THAT(outcome.failure, Catch::Contains("ms"));
  CHECK_THAT(outcome.remedy, Catch::Contains("substeps"));

  auto expected = unstable(false);
  expected.push_back("expect_stop={ reason = \"unstable-step\" }");
  CHECK(run_scenario(read("paper/figure-1.toml", expected), {}).exit == ExitCode::pass);
}

TEST_CASE("divergence stops at the first bad step, and another reason than the expected one fails") {
  auto set = unstable(true);
  set.push_back("expect_stop={ reason = \"diverged\", at_most_step = 400 }");
  set.push_back("run.duration=\"1.4 s\"");
  const RunOutcome outcome = run_scenario(read("paper/figure-1.toml", set), {});
  INFO(outcome.failure);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK_THAT(outcome.failure, Catch::Contains("not finite"));

  auto other = unstable(true);
  other.push_back("expect_stop={ reason = \"bad-input\" }");
  other.push_back("run.duration=\"1.4 s\"");
  CHECK(run_scenario(read("paper/figure-1.toml", other), {}).exit == ExitCode::run_failed);
}

TEST_CASE("a run that was expected to stop and did not fails") {
  CHECK(run_scenario(read("paper/figure-1-spring.toml",
                          {"run.duration=\"0.6 s\"", "expect=[]", "expect_stop={ reason = \"diverged\" }"}),
                     {})
            .exit == ExitCode::expectation_failed);
}

TEST_CASE("an interrupt ends a run with 130 and keeps what was done") {
  const std::atomic<bool> interrupted{true};
  RunOptions options;
  options.control.interrupted = &interrupted;
  const RunOutcome outcome = run_scenario(read("paper/figure-1-spring.toml"), options);
  CHECK(outcome.exit == ExitCode::interrupted);
  CHECK(outcome.record.strategies.size() == 4);
  CHECK_FALSE(outcome.record.strategies[1].events.empty());
}

TEST_CASE("an interrupt of very short steps waits for 10,000 of them at most") {
  const std::atomic<bool> interrupted{true};
  RunOptions options;
  options.control.interrupted = &interrupted;
  const RunOutcome outcome =
      run_scenario(read("paper/figure-1-spring.toml",
                        {"timing.steps=200000", "timing.order=\"concurrent\"", "timing.paced=true", "run.duration=\"50 ms\"",
                         "run.warmup=\"0 s\"", "run.strategies=[\"direct\"]", "expect=[]"}),
                   options);
  REQUIRE(outcome.exit == ExitCode::interrupted);
  const std::size_t steps = outcome.record.strategies.at(0).steps.size();
  CHECK(steps > 9'000);
  CHECK(steps <= 10'001);
}

TEST_CASE("a limit ends a run with its name and value, never with a hang") {
  for (const auto& [limits, name] : {std::pair{SchedulerLimits{.total_events = 1000}, "total"},
                                     std::pair{SchedulerLimits{.events_per_instant = 1}, "instant"},
                                     std::pair{SchedulerLimits{.pending_events = 1}, "pending"}}) {
    RunOptions options;
    options.control.limits = limits;
    const RunOutcome outcome = run_scenario(read("paper/ties.toml"), options);
    INFO(outcome.failure);
    CHECK(outcome.exit == ExitCode::run_failed);
    CHECK_THAT(outcome.failure, Catch::Contains(name));
    CHECK_FALSE(outcome.remedy.empty());
  }
}

TEST_CASE("a run that stops early has the same trace hash whether its events are kept or not") {
  std::vector<std::string> diverging = unstable(true);
  diverging.insert(diverging.end(), {"run.duration=\"1.4 s\"", "expect_stop={ reason = \"diverged\" }"});
  const std::vector<std::string> interrupted{"expect=[]", "run.interrupt=\"0.4 s\""};
  const std::vector<std::string> unplugged{"expect=[]", "device.left.unplug=\"0.4 s\"",
                                           "expect_stop={ reason = \"device\" }"};
  for (const auto& [file, set] : {std::pair{"paper/figure-1.toml", diverging},
                                  {"paper/figure-1-spring.toml", interrupted},
                                  {"paper/figure-1-spring.toml", unplugged}}) {
    std::vector<std::string> summary = set;
    summary.push_back("run.keep=\"summary\"");
    const RunRecord all = run_scenario(read(file, set), {}).record, kept = run_scenario(read(file, summary), {}).record;
    INFO(file << ' ' << set.back());
    REQUIRE_FALSE(all.strategies.empty());
    REQUIRE(all.strategies.size() == kept.strategies.size());
    CHECK(all.trace_hash == kept.trace_hash);
    for (std::size_t i = 0; i < all.strategies.size(); ++i) {
      CHECK(all.strategies[i].trace_hash == kept.strategies[i].trace_hash);
      CHECK(kept.strategies[i].trace_hash != 0);
    }
  }
}
