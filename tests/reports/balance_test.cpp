// The conservation laws of a run: whichever number is changed by one, one of the laws breaks.

#include "evenstep/reports/balance.h"

#include "synthetic.h"

using namespace evenstep;

namespace {

/// The reference run, in virtual time, with the counts that its lanes would have taken.
RunRecord balanced_run() {
  RunRecord run = synthetic::reference_run();
  run.clock = "virtual";
  run.keep_rows = true;
  for (StrategyRecord& strategy : run.strategies) {
    DeviceRecord& device = strategy.devices[0];
    const std::int64_t ticks = std::ssize(device.ticks), steps = std::ssize(strategy.steps);
    strategy.steps_due = strategy.steps_begun = steps;
    strategy.underruns.clear();
    for (std::size_t n = 0; n < strategy.steps.size(); ++n) {
      const auto step = static_cast<std::int64_t>(n);
      if (device.steps[n].read == StepRead::underrun)
        strategy.underruns.push_back({step, 0, UnderrunRow::Side::interaction, {}, "clamp"});
      if (strategy.steps[n].end > strategy.steps[n].emission)
        strategy.underruns.push_back({step, 0, UnderrunRow::Side::force, {}, "hold"});
    }
    strategy.event_counts = {{"device.tick", ticks}, {"completion.step", steps}, {"launch.launch", steps}};
    device.counters = {{"reports", static_cast<double>(ticks - 1)}, {"stale", 1}};
    device.flow = DeviceFlow{.ticks_unforced = 3,
                             .ticks_on_time = ticks - 3,
                             .samples = ticks,
                             .forces = steps,
                             .forces_sent = steps - 7,
                             .forces_overtaken = 4,
                             .forces_dropped = 1,
                             .forces_pending = 2};
  }
  return run;
}

}  // namespace

TEST_CASE("the counts of a run add up, and without a flow nothing is asked") {
  CHECK(imbalances(balanced_run()) == std::vector<std::string>{});
  CHECK(imbalances(synthetic::reference_run()) == std::vector<std::string>{});
}

TEST_CASE("each count that is changed by one breaks a law, which is named with its numbers") {
  const std::vector<std::function<void(StrategyRecord&)>> faults{
      [](StrategyRecord& s) { ++s.devices[0].flow->ticks_skipped; },
      [](StrategyRecord& s) { ++s.devices[0].flow->ticks_unforced; },
      [](StrategyRecord& s) { ++s.devices[0].flow->ticks_underrun; },
      [](StrategyRecord& s) { ++s.devices[0].flow->ticks_overrun; },
      [](StrategyRecord& s) { --s.devices[0].flow->ticks_on_time; },
      [](StrategyRecord& s) { --s.devices[0].flow->samples; },
      [](StrategyRecord& s) { ++s.devices[0].flow->samples_repeated; },
      [](StrategyRecord& s) { --s.devices[0].flow->forces; },
      [](StrategyRecord& s) { --s.devices[0].flow->forces_sent; },
      [](StrategyRecord& s) { ++s.devices[0].flow->forces_overtaken; },
      [](StrategyRecord& s) { ++s.devices[0].flow->forces_dropped; },
      [](StrategyRecord& s) { --s.devices[0].flow->forces_pending; },
      [](StrategyRecord& s) { s.devices[0].ticks.pop_back(); },
      [](StrategyRecord& s) { s.devices[0].steps.pop_back(); },
      [](StrategyRecord& s) { s.steps.pop_back(); },
      [](StrategyRecord& s) { --s.steps_begun; },
      [](StrategyRecord& s) { --*s.steps_due; },
      [](StrategyRecord& s) { s.steps_begun += 2; },
      [](StrategyRecord& s) {
        s.underruns.push_back({0, 0, UnderrunRow::Side::force, {}, "hold"});
      },
      [](StrategyRecord& s) { --s.devices[0].counters["reports"]; },
      [](StrategyRecord& s) { --s.devices[0].counters["stale"]; },
      [](StrategyRecord& s) { s.devices[0].counters["stale"] += 1e6; },
      [](StrategyRecord& s) { --s.event_counts["device.tick"]; },
      [](StrategyRecord& s) { --s.event_counts["completion.step"]; },
      [](StrategyRecord& s) { --s.event_counts["launch.launch"]; },
  };
  for (std::size_t i = 0; i < faults.size(); ++i) {
    RunRecord run = balanced_run();
    faults[i](run.strategies[3]);
    CAPTURE(i);
    const std::vector<std::string> broken = imbalances(run);
    REQUIRE_FALSE(broken.empty());
    CHECK_THAT(broken[0], Catch::Contains("phase_locked: "));
  }
  RunRecord run = balanced_run();
  --run.strategies[3].devices[0].flow->samples;
  CHECK(imbalances(run) ==
        std::vector<std::string>{"left, phase_locked: 1999 samples are in the ring, or were already, 2000 ticks ran"});
}

TEST_CASE("a late machine may skip ticks and fall behind, and a signal may end a run, if all of it is counted") {
  RunRecord run = balanced_run();
  run.clock = "wall";
  StrategyRecord& live = run.strategies[3];
  DeviceRecord& device = live.devices[0];
  device.ticks.erase(device.ticks.begin() + 500, device.ticks.begin() + 520);
  device.flow->ticks_skipped = 20;
  device.flow->samples -= 20;
  device.flow->ticks_on_time -= 20;
  live.event_counts["device.tick"] -= 20;
  *live.steps_due += 30;
  ++live.steps_begun;
  ++live.event_counts["launch.launch"];
  CHECK(imbalances(run) == std::vector<std::string>{});
}
