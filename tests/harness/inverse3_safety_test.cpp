// The scenarios of scenarios/safety that name no driver, on a Haply Inverse3. Those about reports have a twin that is
// shipped.

#include <fmt/format.h>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("what the guard does in the safety scenarios it does above inverse3, too") {
  for (const std::string name : {"clamp-and-slew", "gain-and-ramp", "gain-and-ramp-control", "speed", "stale-force",
                                 "stale-hand", "stale-hand-control"}) {
    const std::vector<std::string> set{"device.left.driver=\"inverse3\"",
                                       "device.left.inverse3={ origin = [\"0 m\", \"-0.12 m\", \"0.15 m\"] }"};
    const RunOutcome outcome = run_scenario(read("safety/" + name + ".toml", set), {});
    INFO(name << ": " << outcome.failure);
    CHECK((outcome.exit == ExitCode::pass || outcome.exit == ExitCode::expectation_failed));
    for (const ExpectationResult& result : outcome.results) {
      INFO(result.metric << " " << result.detail);
      if (result.metric == "lost") continue;  // positions have no number
      REQUIRE(result.value);
      const double allowed = result.metric == "motors_max" ? 1e-5 : 0;  // the service counts in single precision
      if (result.min) CHECK(*result.value >= *result.min - allowed);
      if (result.max) CHECK(*result.value <= *result.max + allowed);
    }
    for (const StrategyRecord& record : outcome.record.strategies)
      CHECK(outcome.metrics.at("left.force." + record.name).at("motors_left") == 0);
  }
}
