// The scenarios of scenarios/safety that name no driver, on the drivers whose samples have no number: what they expect holds
// there, too. Those about reports have a twin for each of these drivers that is shipped.

#include <fmt/format.h>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Driver {
  std::vector<std::string> set;
  double motors_N = 0;         ///< what a force may differ by
  double cuts_stale_hand = 0;  ///< what they may
  bool has_z = true;
};

void guard_holds_above(const Driver& driver) {
  for (const std::string name : {"clamp-and-slew", "gain-and-ramp", "gain-and-ramp-control", "speed", "stale-force",
                                 "stale-hand", "stale-hand-control"}) {
    const RunOutcome outcome = run_scenario(read("safety/" + name + ".toml", driver.set), {});
    INFO(name << ": " << outcome.failure);
    CHECK((outcome.exit == ExitCode::pass || outcome.exit == ExitCode::expectation_failed));
    for (const ExpectationResult& result : outcome.results) {
      INFO(result.metric << " " << result.detail);
      if (result.metric == "lost") continue;  // positions have no number
      REQUIRE(result.value);
      const double allowed = result.metric == "motors_max"        ? driver.motors_N
                             : result.metric == "cuts_stale_hand" ? driver.cuts_stale_hand
                                                                  : 0;
      if (result.min) CHECK(*result.value >= *result.min - allowed);
      if (result.max) CHECK(*result.value <= *result.max + allowed);
    }
    for (const StrategyRecord& record : outcome.record.strategies) {
      const auto& motors = outcome.metrics.at("left.force." + record.name);
      CHECK(motors.at("motors_left") == 0);
      if (!driver.has_z) CHECK(motors.at("motors_max_z") == 0);
    }
  }
}

}  // namespace

TEST_CASE("what the guard does in the safety scenarios it does above evdev, too", "[sweep]") {
  // Its axes end at 0.3 m. Nobody reports the hand: that is what two of them are about. A force is off by some counts of
  // 100 N; and at the start the hand moves no count for longer than it may be unreported.
  guard_holds_above({.set = {"device.left.driver=\"evdev\"",
                             "device.left.evdev={ travel = [\"0.6 m\", \"0.6 m\", \"0 m\"], full_scale = \"100 N\", gain = "
                             "1.0, still = \"0 s\" }"},
                     .motors_N = 0.02,
                     .cuts_stale_hand = 1,
                     .has_z = false});
}

TEST_CASE("what the guard does in the safety scenarios it does above inverse3, too", "[sweep]") {
  guard_holds_above(
      {.set = {"device.left.driver=\"inverse3\"", "device.left.inverse3={ origin = [\"0 m\", \"-0.12 m\", \"0.15 m\"] }"},
       .motors_N = 1e-5});  // the service counts in single precision
}
