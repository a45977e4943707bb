// What a run on the wall clock says about itself.

#include "catch.h"
#include "evenstep/reports/writers.h"
#include "synthetic.h"

using namespace evenstep;
using Catch::Contains;

namespace {

/// The reference run as if phase_locked had run live: every tenth tick is 1 ms late, one 7 ms, and two never ran.
RunRecord live_run() {
  RunRecord run = synthetic::reference_run();
  run.clock = "wall";
  run.live = "phase_locked";
  for (StrategyRecord& strategy : run.strategies) {
    strategy.shadow = strategy.name == "direct" || strategy.name == "paper";
    if (strategy.name != run.live) continue;
    Rows<TickRow>& ticks = strategy.devices[0].ticks;
    for (std::size_t k = 0; k < ticks.size(); k += 10) ticks[k].lateness = Duration{1'000'000};
    ticks[500].lateness = Duration{7'000'000};
    ticks.erase(ticks.begin() + 1001, ticks.begin() + 1003);
  }
  return run;
}

}  // namespace

TEST_CASE("lateness is that of exactly the live ticks, without the ideal twin's and the shadows'") {
  const RunRecord run = live_run();
  const auto values = measure(run).at("events.device.tick");
  CHECK(values.at("ticks_run") == 1998);
  CHECK(values.at("deadline_misses") == 2);
  CHECK(values.at("deadline_miss_share") == Approx(2.0 / 2000).epsilon(1e-15));
  CHECK(values.at("lateness_max") == 7e-3);
  // A tenth of the live ticks is late, which is 3 % of all ticks that were recorded.
  CHECK(values.at("lateness_p50") == 0);
  CHECK(values.at("lateness_p99") == 1e-3);
  CHECK(values.at("lateness_p999") == 1e-3);
  RunRecord every_second = run;
  for (StrategyRecord& strategy : every_second.strategies) {
    if (strategy.name != run.live) continue;
    for (std::size_t k = 0; k < strategy.devices[0].ticks.size(); ++k)
      strategy.devices[0].ticks[k].lateness = Duration{k % 3 == 0 ? 0 : 2'000'000};
  }
  CHECK(measure(every_second).at("events.device.tick").at("lateness_p50") == 2e-3);
}

TEST_CASE("ticks are missed at the end of a run as they are in its middle: after the last tick that ran, none did") {
  RunRecord run = live_run();
  for (StrategyRecord& strategy : run.strategies) {
    Rows<TickRow>& ticks = strategy.devices[0].ticks;
    if (strategy.name == run.live) ticks.erase(ticks.end() - 3, ticks.end());
  }
  const auto values = measure(run).at("events.device.tick");
  CHECK(values.at("ticks_run") == 1995);
  CHECK(values.at("deadline_misses") == 5);
}

TEST_CASE("ticks past the end are not missed: a recording that was cut off may hold more of the ticks than of the steps") {
  RunRecord run = live_run();
  run.nominal.end = run.nominal.end - Duration{6'000'000};
  const auto values = measure(run).at("events.device.tick");
  CHECK(values.at("ticks_run") == 1998);
  CHECK(values.at("deadline_misses") == 2);
}

TEST_CASE("a live run says what it was granted, and how to get what it was not") {
  RunRecord run = live_run();
  CHECK_THAT(live_lines(run, measure(run)), !Contains("rights"));
  run.rights = LiveRights{{{"device", 45, true, 0, 0, ""}, {"solver", 35, true, 1, 0, ""}}, true, ""};
  CHECK_THAT(live_lines(run, measure(run)),
             Contains("rights       device SCHED_FIFO 45, solver SCHED_FIFO 35, memory locked, timer slack 1 ns\n"));
  CHECK_THAT(live_lines(run, measure(run)), !Contains("limits.d"));
  run.rights->cores_awake = true;
  CHECK_THAT(live_lines(run, measure(run)), Contains("timer slack 1 ns, cores kept awake\n"));
  run.rights->cores_awake = false;
  CHECK_THAT(live_lines(run, measure(run)), Contains("timer slack 1 ns, refused to keep cores awake\n"));
  run.rights->cores_awake.reset();
  run.rights->threads[0].fifo = false;
  run.rights->threads[0].slice_ns = 100'000;
  run.rights->memory_locked = false;
  CHECK_THAT(live_lines(run, measure(run)),
             Contains("rights       device refused SCHED_FIFO 45 (a slice of 0.1 ms instead), solver SCHED_FIFO 35, memory "
                      "not locked, timer slack 1 ns\n") &&
                 Contains("/etc/security/limits.d/evenstep.conf") && Contains(" - rtprio 45\n") &&
                 Contains(" - memlock unlimited\n"));
}

TEST_CASE("a live run says how long it ran, how late it was and what it missed, in whole sentences of one line each") {
  RunRecord run = live_run();
  StrategyRecord& live = run.strategies[3];
  live.devices[0].counters = {{"clamped", 3}, {"cuts_speed", 1}, {"cuts_device", 2}, {"slewed", 0}};
  live.steps_due = 903;
  live.steps_begun = 901;
  live.devices[0].flow = DeviceFlow{.forces = 900, .forces_sent = 880, .forces_overtaken = 12, .forces_pending = 8};
  live.devices[0].steps[200].read = StepRead::underrun;
  live.steps[201].end = live.steps[201].emission + Duration{1};
  const Metrics metrics = measure(run);
  run.nominal.end = RealTime{1'234'000'000};
  const std::string text = live_lines(run, metrics);
  CHECK_THAT(
      text,
      Contains("live         phase_locked for 1.23 s on the wall clock: 900 steps, 1998 ticks, 2 ticks missed (0.1 %)\n"));
  CHECK_THAT(text, Contains("lateness     p50 0 ms, p99 1 ms, p99.9 1 ms, max 7 ms\n"));
  CHECK_THAT(text, Contains("steps        901 began, 2 that were programmed did not: the simulation fell behind\n"));
  CHECK_THAT(
      text,
      Contains("left         900 forces: 880 sent, 12 overtaken by a newer one, 0 dropped, 8 due after the last tick\n"));
  CHECK_THAT(text, Contains("left         1 samples missing, 1 forces late of 780 judged steps; 3 cuts, 3 clamped\n"));
}

TEST_CASE("a device that did not say how many effects it plays at once is named once, whatever the clock") {
  RunRecord run = synthetic::reference_run();
  CHECK(device_notes(run).empty());
  for (StrategyRecord& strategy : run.strategies) strategy.devices[0].counters["pid_pool_unknown"] = 0;
  CHECK(device_notes(run).empty());
  for (StrategyRecord& strategy : run.strategies) strategy.devices[0].counters["pid_pool_unknown"] = 1;
  CHECK(device_notes(run) ==
        "left         did not say, or not believably, how many effects it plays at once; it is driven all the same\n");
}

TEST_CASE("a run in virtual time has nothing to say about the machine") {
  const RunRecord run = synthetic::reference_run();
  CHECK(live_lines(run, measure(run)).empty());
}
