// Lanes on two schedulers that are driven in lock step give the same events and forces as lanes on one scheduler.

#include "evenstep/clock/virtual_clock.h"
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

      VirtualClock device_clock, simulation_clock;
      SimulatedDevices devices(scenario, device_clock);
      DeviceExchange exchange(links_of(scenario, plan), devices.drivers());
      StrategyLanes lanes(scenario, plan, make_scenario_solver(scenario, plan.kind), exchange, make_timing(scenario.timing),
                          devices.drivers());
      InlineExecutor executor;
      Scheduler simulation(simulation_clock, executor), device(device_clock, executor);
      lanes.spawn(device, simulation);
      const RealTime end{scenario.run_duration.ns};
      for (;;) {
        const auto a = device.next(), b = simulation.next();
        const bool a_runs = a && a->time < end, b_runs = b && b->time < end;
        if (!a_runs && !b_runs) break;
        const bool device_first = a_runs && (!b_runs || std::pair(a->time, a->lane) < std::pair(b->time, b->lane));
        REQUIRE((device_first ? device : simulation).run_one());
      }
      for (const Event& event : merge(simulation.events(), device.events())) lanes.keep(event);
      const StrategyRecord record = lanes.finish(end);

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
