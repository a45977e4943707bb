// The scenarios of scenarios/safety that name no driver, run on the drivers whose samples are not numbered: their
// expectations hold there, too. For the scenarios about reports, a twin for each of these drivers is shipped.

#include <fmt/format.h>

#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

struct Driver {
  std::vector<std::string> set;
  double motors_N = 0;         ///< how far the largest force may be beyond its limits
  double cuts_stale_hand = 0;  ///< how far the number of these cuts may be
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
      if (result.metric == "lost") continue;  // samples are not numbered
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
  // The axes of this device end at 0.3 m. With `still = 0` a hand that is not reported is stale, which is what two of the
  // scenarios are about. A force is off by some counts of 100 N. At the start the hand moves less than a count for longer
  // than it may go unreported, hence one cut more.
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
