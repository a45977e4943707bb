// What the driver of a PID device counts reaches the run's metrics.

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

const std::string kForce = "left.force.phase_locked";

RunOutcome outcome_of(const std::string& file, std::vector<std::string> set) {
  set.push_back("run.strategies=[\"phase_locked\"]");
  RunOutcome outcome = run_scenario(read(file, set), {});
  INFO(outcome.failure);
  REQUIRE(outcome.failure.empty());
  REQUIRE(outcome.metrics.count(kForce) == 1);
  return outcome;
}

}  // namespace

TEST_CASE("a force beyond a PID device's full scale is counted at each tick that wanted it") {
  for (const char* gain : {"1.0", "0.5"}) {
    const std::string pid =
        "device.left.pid={ travel = [\"1 m\", \"1 m\", \"0 mm\"], full_scale = \"40 N\", gain = " + std::string(gain) + " }";
    const RunOutcome outcome = outcome_of(
        "paper/figure-1-spring.toml", {"expect=[]", "device.left.driver=\"pid\"", pid, "device.left.force_limit=\"1 kN\""});
    // Up to 76 N are wanted: 200 N/m, 0.1 m/s, 4 s.
    const double largest_N = std::string(gain) == "1.0" ? 40 : 20;
    std::int64_t beyond = 0;
    for (const TickRow& tick : strategy(outcome.record, "phase_locked").devices[0].ticks)
      beyond += std::abs(tick.force_N[0]) > largest_N;
    INFO("gain " << gain);
    CHECK(beyond > 1000);
    CHECK(outcome.metrics.at(kForce).at("pid_saturated") == static_cast<double>(beyond));
    CHECK(outcome.metrics.at(kForce).at("pid_unpowered") == 0);
    CHECK(outcome.metrics.at(kForce).at("motors_max") == Approx(largest_N).epsilon(1e-3));
  }
}

TEST_CASE("what is sent to a PID device while its motors are off is counted, and how often its effects are started again") {
  // Off from 2 s to 3 s and from 4 s to 4.5 s, told by the next report.
  const RunOutcome outcome = outcome_of("safety/switches-mask.toml", {});
  const auto& values = outcome.metrics.at(kForce);
  CHECK(values.at("pid_unpowered") == Approx(1500).margin(2));
  CHECK(values.at("pid_saturated") == 0);
  CHECK(values.at("effects_ended") == 0);
  CHECK(values.at("pid_refreshes") > 0);
  CHECK(values.at("pid_refreshes") < 0.1 * 6000);  // in time, not at every tick
}

TEST_CASE("a device that is not of the PID class has none of its counters, and expecting one is an error") {
  const std::string refreshes = "expect=[{ signal = \"" + kForce + "\", metric = \"pid_refreshes\", max = 10 }]";
  const RunOutcome outcome = outcome_of("paper/figure-1-spring.toml", {refreshes, "run.duration=\"0.6 s\""});
  for (const char* name : {"pid_saturated", "pid_unpowered", "pid_refreshes"})
    CHECK(outcome.metrics.at(kForce).count(name) == 0);
  CHECK(outcome.exit == ExitCode::usage);
  CHECK(outcome.results.at(0).verdict == ExpectationResult::Verdict::error);
  CHECK_THAT(outcome.results.at(0).detail, Catch::Contains("no sample was judged"));
}
