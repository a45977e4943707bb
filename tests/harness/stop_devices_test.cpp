// However a run ends, its simulated devices do not drive afterwards. If one does, the run has failed and says which.

#include <map>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::vector<std::string> kDrivers{"reference", "pid"};
/// From `at` on, everything that the host writes is lost, including the stop.
std::string lost_from(const std::string& at) {
  return "device.left.faults=[{ kind = \"write-lost\", at = \"" + at + "\", amount = 100000 }]";
}

RunOutcome run_with(const std::string& name, std::vector<std::string> set) {
  return run_scenario(read("safety/" + name + ".toml", set), {});
}

}  // namespace

TEST_CASE("a run whose device still drives at its end has failed however it ended and whatever was expected") {
  const std::map<std::string, std::string> ends{
      {"exit", "3.9 s"}, {"signal", "0.9 s"}, {"solver-error", "0.05 s"}, {"hand-lost", "0.05 s"}};
  for (const std::string& driver : kDrivers) {
    for (const auto& [end, from] : ends) {
      const std::string name = end + "-" + driver;
      INFO(name);
      CHECK(run_with(name, {}).exit == ExitCode::pass);
      const RunOutcome outcome = run_with(name, {lost_from(from)});
      INFO(outcome.failure);
      CHECK(outcome.exit == ExitCode::run_failed);
      CHECK_THAT(outcome.failure, Catch::StartsWith("left: the device still drives after its driver has stopped: ") &&
                                      Catch::Contains(driver == "pid" ? "are allocated, actuators on"
                                                                      : "0 effects play, 0 are allocated, actuators off"));
      CHECK_FALSE(outcome.remedy.empty());
      CHECK(outcome.record.strategies.empty());
    }
  }
}

TEST_CASE("a device that is only read may center by itself: its driver has nothing to stop") {
  std::vector<std::string> set{"run.duration=\"0.3 s\"", "run.warmup=\"0.1 s\"", "expect=[]", "device.left.driver=\"evdev\"",
                               "device.left.evdev={ travel = [\"200 mm\", \"200 mm\", \"0 mm\"] }"};
  const RunOutcome read_only = run_scenario(read("paper/figure-1-spring.toml", set), {});
  CHECK(read_only.failure.empty());
  REQUIRE(!read_only.record.strategies.empty());
  CHECK(read_only.record.strategies[0].devices[0].counters.at("motors_left") > 0);
  // One that was told something must be at rest.
  set.back() = "device.left.evdev={ travel = [\"200 mm\", \"200 mm\", \"0 mm\"], full_scale = \"10 N\" }";
  CHECK(run_scenario(read("paper/figure-1-spring.toml", set), {}).failure.empty());
  set.push_back(lost_from("0 s"));
  CHECK_THAT(run_scenario(read("paper/figure-1-spring.toml", set), {}).failure,
             Catch::StartsWith("left: the device still drives after its driver has stopped: "));
}

TEST_CASE("a scenario cannot expect that a device still drives") {
  const std::vector<std::string> set{"expect_stop={ reason = \"still-driving\" }"};
  CHECK_FALSE(read_scenario(shipped("safety/exit-pid.toml"), {set, std::nullopt}));
}

TEST_CASE("an interrupt is heard within 20 ms wherever it comes and leaves nothing behind") {
  for (const std::string& driver : kDrivers) {
    for (int ms = 0; ms < 100; ms += 7) {
      const RunOutcome outcome =
          run_with("signal-" + driver, {"run.interrupt=\"" + std::to_string(ms) + " ms\"", "run.duration=\"0.2 s\"",
                                        "run.warmup=\"0 s\"", "expect=[]", "expect_stop={ reason = \"interrupted\" }"});
      INFO(driver << " " << ms << " ms: " << outcome.failure);
      CHECK(outcome.exit == ExitCode::pass);
      REQUIRE(outcome.record.strategies.size() == 2);
      for (const StrategyRecord& record : outcome.record.strategies) {
        CHECK(record.interrupted);
        const DeviceRecord& device = record.devices.at(0);
        const std::int64_t last_ms = device.ticks.back().at.ns / 1'000'000;
        CHECK((last_ms >= ms && last_ms <= ms + 20));
        CHECK(device.counters.at("motors_left") == 0);
      }
    }
  }
}

TEST_CASE("an interrupt that the scenario does not expect fails and one that does not come fails too") {
  const RunOutcome unexpected = run_with("exit-pid", {"run.interrupt=\"1 s\""});
  CHECK(unexpected.exit == ExitCode::run_failed);
  CHECK_THAT(unexpected.failure, Catch::Contains("interrupted at 1 s"));
  // In the last 20 ms an interrupt comes too late: the run goes to its end.
  const RunOutcome late = run_with("signal-pid", {"run.interrupt=\"3.985 s\"", "expect=[]"});
  CHECK(late.exit == ExitCode::expectation_failed);
  CHECK_THAT(late.failure, Catch::Contains("ran to its end"));
}

TEST_CASE("a stop must come with its message and between its steps") {
  const auto exit_with = [](const std::string& stop) {
    return run_with("unplug", {"expect=[]", "expect_stop={ reason = \"device\", " + stop + " }"}).exit;
  };
  CHECK(exit_with("at_least_step = 450, at_most_step = 450") == ExitCode::pass);
  CHECK(exit_with("at_least_step = 451") == ExitCode::expectation_failed);
  CHECK(exit_with("at_most_step = 449") == ExitCode::expectation_failed);
  CHECK(exit_with("message = \"is gone\"") == ExitCode::pass);
  CHECK(exit_with("message = \"has gone\"") == ExitCode::expectation_failed);
}

TEST_CASE("an expectation beside the right stop is judged on what was recorded until then") {
  const std::string stop = "expect_stop={ reason = \"device\" }";
  const auto result_of = [&](const std::string& limit) {
    const std::string expect = "expect=[{ signal = \"left.force.phase_locked\", metric = \"motors_max\", " + limit + " }]";
    return run_with("unplug-pid", {stop, expect});
  };
  CHECK(result_of("min = \"3.4 N\"").exit == ExitCode::pass);
  const RunOutcome failed = result_of("min = \"3.7 N\"");
  CHECK(failed.exit == ExitCode::expectation_failed);
  REQUIRE(failed.results.size() == 1);
  CHECK(*failed.results[0].value == Approx(3.5).margin(0.1));
  // A device that never started recorded nothing: that is an error, not a pass.
  const std::string never = "expect=[{ signal = \"left.force.phase_locked\", metric = \"motors_left\", max = 0 }]";
  CHECK(run_with("pid-pool-full", {never}).exit == ExitCode::usage);
}

TEST_CASE("on a wall clock simulated devices do not drive after the run either") {
  RunOptions options;
  options.clock = ClockKind::wall;
  std::vector<std::string> set{"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\""};
  const RunOutcome interrupted = run_scenario(read("safety/signal-pid.toml", set), options);
  CHECK(interrupted.exit == ExitCode::usage);
  REQUIRE_FALSE(interrupted.errors.empty());
  CHECK_THAT(interrupted.errors.back().message, Catch::Contains("press Ctrl-C"));

  set.insert(set.end(), {"run.duration=\"0.3 s\"", "run.warmup=\"0 s\"", "expect=[]"});
  options.allow_no_expectations = true;
  for (const std::string& driver : kDrivers) {
    const RunOutcome outcome = run_scenario(read("safety/exit-" + driver + ".toml", set), options);
    INFO(outcome.failure);
    CHECK(outcome.exit == ExitCode::pass);
    CHECK(strategy(outcome.record, "phase_locked").devices.at(0).counters.at("motors_left") == 0);
  }
  // The effects were made before the first tick. The stop comes after it and is lost.
  set.push_back(lost_from("0 s"));
  const RunOutcome lost = run_scenario(read("safety/exit-pid.toml", set), options);
  CHECK(lost.exit == ExitCode::run_failed);
  CHECK_THAT(lost.failure, Catch::StartsWith("left: the device still drives") && Catch::Contains("2 effects play"));
}
