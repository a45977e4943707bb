// How a live run begins to read a device that has been open for a while. Nothing here depends on how fast the machine is.
#include "../harness/scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("what Linux drops before a live run begins to read is not counted as lost to it") {
  const Scenario scenario =
      read("paper/figure-1-spring.toml",
           {"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"0.4 s\"", "run.warmup=\"0.1 s\"", "expect=[]",
            "device.0.driver=\"evdev\"", "device.0.evdev={travel=[\"0.4 m\", \"0.4 m\", \"0 m\"], full_scale=\"10 N\"}"});
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.devices.bindings = {{"", "/dev/input/event7"}};
  const RunOutcome outcome = run_scenario(scenario, options);
  for (const Diagnostic& error : outcome.errors) UNSCOPED_INFO(text(error));
  INFO(outcome.failure << outcome.repeat_difference);
  REQUIRE(outcome.exit == ExitCode::pass);
  const auto& force = outcome.metrics.at("left.force.phase_locked");
  CHECK(force.at("evdev_dropped") == 0);
  // There is a report for each tick, and none for what came before the first tick.
  const DeviceRecord& device = strategy(outcome.record, "phase_locked").devices[0];
  CHECK(force.at("reports") == static_cast<double>(device.ticks.size()));
  REQUIRE(device.ticks.size() > 1);
}
