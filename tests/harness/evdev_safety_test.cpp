// The scenarios of scenarios/safety that name no driver, on a device of Linux' input core: what they expect holds there,
// too. Those about PID reports have a twin for evdev that is shipped.

#include <fmt/format.h>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("what the guard does in the safety scenarios it does above evdev, too") {
  for (const std::string name : {"clamp-and-slew", "gain-and-ramp", "gain-and-ramp-control", "speed", "stale-force",
                                 "stale-hand", "stale-hand-control"}) {
    // Its axes end at 0.3 m. Nobody reports the hand: that is what two of them are about.
    const std::vector<std::string> set{"device.left.driver=\"evdev\"",
                                       "device.left.evdev={ travel = [\"0.6 m\", \"0.6 m\", \"0 m\"], full_scale = \"100 "
                                       "N\", gain = 1.0, still = \"0 s\" }"};
    const RunOutcome outcome = run_scenario(read("safety/" + name + ".toml", set), {});
    INFO(name << ": " << outcome.failure);
    CHECK((outcome.exit == ExitCode::pass || outcome.exit == ExitCode::expectation_failed));
    for (const ExpectationResult& result : outcome.results) {
      INFO(result.metric << " " << result.detail);
      if (result.metric == "lost") continue;  // positions have no number
      REQUIRE(result.value);
      // Some counts of 100 N; and at the start the hand moves no count for longer than it may be unreported.
      const double allowed = result.metric == "motors_max" ? 0.02 : result.metric == "cuts_stale_hand" ? 1 : 0;
      if (result.min) CHECK(*result.value >= *result.min - allowed);
      if (result.max) CHECK(*result.value <= *result.max + allowed);
    }
    for (const StrategyRecord& record : outcome.record.strategies) {
      const auto& motors = outcome.metrics.at("left.force." + record.name);
      CHECK(motors.at("motors_left") == 0);
      CHECK(motors.at("motors_max_z") == 0);
    }
  }
}
