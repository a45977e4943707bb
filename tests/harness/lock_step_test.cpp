// The lanes on two schedulers, driven in lock step, give the events and the forces of one scheduler.

#include "evenstep/clock/virtual_clock.h"
#include "evenstep/harness/haptic_loop.h"
#include "evenstep/harness/recorder.h"
#include "evenstep/harness/simulated_devices.h"
#include "evenstep/harness/strategy_run.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

TEST_CASE("the lanes on two schedulers in lock step give the same forces and the same chain") {
  const std::string jitter = "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }";
  const std::vector<std::string> set = GENERATE_COPY(std::vector<std::string>{}, std::vector<std::string>{jitter});
  for (const char* file : {"paper/figure-1-spring.toml", "paper/ties.toml"}) {
    if (std::string(file) == "paper/ties.toml" && !set.empty()) continue;
    const Scenario scenario = read(file, set);
    for (const StrategyPlan& plan : plan(scenario)) {
      if (plan.kind == StrategyKind::ideal) continue;
      const StrategyRecord together = run_strategy(scenario, plan, {});

      StrategyRecord record = start_record(scenario, plan);
      VirtualClock device_clock, simulation_clock;
      SimulatedDevices devices(scenario, device_clock);
      const auto solver = make_scenario_solver(scenario);
      const auto timing = make_timing(scenario);
      const auto map = make_map(scenario, plan.kind, plan.lead, plan.latency);
      DeviceExchange exchange({plan.interaction_capacity, plan.force_capacity}, emissions_of(scenario), devices.drivers());
      SolverStep step(*solver, exchange.tool_count(), scenario.scene.needs_state_digest);
      StepRecorder step_recorder(record);
      std::vector<DeviceLane> lanes = device_lanes(scenario, devices.drivers());
      std::vector<DeviceRecorder> recorders(record.devices.begin(), record.devices.end());
      InlineExecutor executor;
      Scheduler simulation(simulation_clock, executor), device(device_clock, executor);
      device.spawn(device_lane(device, lanes[0], exchange, recorders[0]));
      simulation.spawn(simulation_lane(simulation, *timing, *map, step, exchange, step_recorder));
      const RealTime end{scenario.run_duration.ns};
      for (;;) {
        const auto a = device.next(), b = simulation.next();
        const bool a_runs = a && a->time < end, b_runs = b && b->time < end;
        if (!a_runs && !b_runs) break;
        const bool device_first = a_runs && (!b_runs || std::pair(a->time, a->lane) < std::pair(b->time, b->lane));
        REQUIRE((device_first ? device : simulation).run_one());
      }
      keep_events(merge(simulation.events(), device.events()), record);

      INFO(file << " " << record.name);
      CHECK(record.trace_hash == together.trace_hash);
      REQUIRE(record.devices[0].ticks.size() == together.devices[0].ticks.size());
      std::int64_t different = 0;
      for (std::size_t k = 0; k < record.devices[0].ticks.size(); ++k) {
        different += record.devices[0].ticks[k].force_N != together.devices[0].ticks[k].force_N;
      }
      CHECK(different == 0);
    }
  }
}
