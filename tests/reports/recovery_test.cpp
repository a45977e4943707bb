#include "evenstep/reports/recovery.h"

#include <cmath>
#include <limits>
#include <random>

#include "cases.h"
#include "catch.h"
#include "evenstep/reports/measures.h"
#include "synthetic.h"

namespace evenstep {
namespace {

using Over = ProgrammedFault::Over;
using State = Recovery::State;
constexpr std::size_t kPhaseLocked = 3;

RealTime at_ms(std::int64_t ms) { return RealTime{ms * 1'000'000}; }

/// A run of `seconds` with a fault in [1 s, 1.2 s) that does no harm.
RunRecord faulty_run(std::int64_t seconds = 3) {
  RunRecord run = synthetic::reference_run(Duration{seconds * 1'000'000'000});
  run.nominal.faults = {{"device.left.faults.0", at_ms(1000), at_ms(1200), Over::at_time}};
  return run;
}

Recovery recovery_in(const RunRecord& run) { return recovery_of(run, run.strategies[kPhaseLocked], 0); }

/// The first step that begins at or after a time.
std::size_t step_at(const RunRecord& run, RealTime time) {
  const auto& steps = run.strategies[kPhaseLocked].steps;
  std::size_t n = 0;
  while (steps[n].begin < time) ++n;
  return n;
}

/// A force that comes `late` after its time, in the step that begins at or after `time`. Returns when it comes.
RealTime make_late(RunRecord& run, RealTime time, Duration late) {
  StepRow& step = run.strategies[kPhaseLocked].steps[step_at(run, time)];
  step.end = step.emission + late;
  return step.end;
}

RealTime device_tick(std::size_t k) { return tick_time(synthetic::kTickRate, static_cast<std::int64_t>(k)); }
std::size_t tick_at(RealTime time) { return static_cast<std::size_t>(first_tick_at_or_after(synthetic::kTickRate, time)); }

}  // namespace

TEST_CASE("A run that nothing disturbs has recovered when its fault is over", "[recovery]") {
  const Recovery recovery = recovery_in(faulty_run());
  CHECK(recovery.state == State::recovered);
  CHECK(recovery.time_s() == 0);
  CHECK(recovery.why.empty());
  CHECK(recovery.faults_end == at_ms(1200));
}

TEST_CASE("A run without a fault has nothing to recover from, and says so", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults.clear();
  CHECK(recovery_in(run).state == State::no_fault);
  CHECK_THAT(recovery_in(run).why, Catch::Contains("no fault is programmed"));
  CHECK(measure(run)["left.force.phase_locked"].count("recovery_time") == 0);
}

TEST_CASE("The last late force, missing sample or acquiring step counts, by when it is", "[recovery]") {
  RunRecord run = faulty_run();
  make_late(run, at_ms(1300), Duration{100'000});
  const RealTime last = make_late(run, at_ms(1400), Duration{100'000});
  CHECK(recovery_in(run).part_s[0] == seconds(last - at_ms(1200)));
  RunRecord missing = faulty_run();
  const std::size_t n = step_at(missing, at_ms(1500));
  StrategyRecord& strategy = missing.strategies[kPhaseLocked];
  strategy.devices[0].steps[n].read = StepRead::underrun;
  CHECK(recovery_in(missing).part_s[0] == seconds(strategy.steps[n].begin - at_ms(1200)));
  RunRecord acquiring = faulty_run();
  acquiring.strategies[kPhaseLocked].steps[n].acquiring = true;
  CHECK(recovery_in(acquiring).part_s[0] == seconds(strategy.steps[n].begin - at_ms(1200)));
}

TEST_CASE("What happens before the fault is over takes no time to recover from", "[recovery]") {
  RunRecord run = faulty_run();
  make_late(run, at_ms(1100), Duration{100'000});
  CHECK(recovery_in(run).part_s[0] == 0);
}

TEST_CASE("A force that is older than before the fault counts until it is no more", "[recovery]") {
  RunRecord run = faulty_run();
  // From 1.3 s to 1.5 s the forces belong to positions 5 ms earlier.
  for (StepRow& step : run.strategies[kPhaseLocked].steps) {
    if (step.begin >= at_ms(1300) && step.begin < at_ms(1500)) step.read = step.read - Duration{5'000'000};
  }
  const Recovery recovery = recovery_in(run);
  REQUIRE(recovery.state == State::recovered);
  CHECK(recovery.part_s[1] > 0.29);
  CHECK(recovery.part_s[1] < 0.32);
  run.nominal.recovery_latency = Duration{6'000'000};
  CHECK(recovery_in(run).part_s[1] == 0);
}

TEST_CASE("A jump counts if it is larger than before the fault by a tenth of a step", "[recovery]") {
  RunRecord run = faulty_run();
  StrategyRecord& strategy = run.strategies[kPhaseLocked];
  const std::size_t n = step_at(run, at_ms(1700));
  strategy.devices[0].steps[n].position_m[1] += 0.04 * synthetic::kStep_m;  // a second difference of 0.08 steps
  CHECK(recovery_in(run).part_s[2] == 0);
  strategy.devices[0].steps[n].position_m[1] += 0.02 * synthetic::kStep_m;  // 0.12
  // The jump appears in three second differences. In the last one, whose samples go on for two steps, it counts only half
  // (0.06 steps), which is not enough. So the last sample that counts is one step later.
  CHECK(recovery_in(run).part_s[2] == seconds(strategy.steps[n + 1].begin - at_ms(1200)));
}

TEST_CASE("A jump of the force at the ticks counts as one of the interaction does", "[recovery]") {
  RunRecord run = faulty_run();
  const std::size_t k = tick_at(at_ms(1800));
  run.strategies[kPhaseLocked].devices[0].ticks[k].force_N[2] += 0.1;
  CHECK(recovery_in(run).part_s[2] == seconds(at_ms(1802) - at_ms(1200)));
}

TEST_CASE("A force that is not a number is no recovery", "[recovery]") {
  RunRecord run = faulty_run();
  run.strategies[kPhaseLocked].devices[0].ticks[tick_at(at_ms(1800))].force_N[0] = std::nan("");
  CHECK(recovery_in(run).part_s[2] == seconds(at_ms(1802) - at_ms(1200)));
}

TEST_CASE("A limit that the force met before the fault is usual, another one is not", "[recovery]") {
  RunRecord run = faulty_run();
  Rows<TickRow>& ticks = run.strategies[kPhaseLocked].devices[0].ticks;
  ticks[tick_at(at_ms(1800))].saturated.add(SaturationCause::cut);
  CHECK(recovery_in(run).part_s[2] == seconds(at_ms(1800) - at_ms(1200)));
  ticks[tick_at(at_ms(600))].saturated.add(SaturationCause::cut);
  CHECK(recovery_in(run).part_s[2] == 0);
}

TEST_CASE("What does not hold when the run ends never recovers, and no number hides it", "[recovery]") {
  RunRecord run = faulty_run();
  make_late(run, at_ms(2900), Duration{100'000});
  const Recovery recovery = recovery_in(run);
  CHECK(recovery.state == State::never);
  CHECK(std::isinf(recovery.time_s()));
  CHECK_THAT(recovery.why, Catch::Contains("never, within"));
  CHECK_THAT(recovery.why, Catch::Contains("a force late"));
  Metrics metrics = measure(run);
  CHECK(std::isinf(metrics["left.force.phase_locked"]["recovery_time"]));
  CHECK(metrics["left.force.phase_locked"]["recovered"] == 0);
  CHECK(metrics["left.force.phase_locked"]["recovery_time_latency"] == 0);
}

TEST_CASE("A fault that lasts until the end is never recovered from", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults.push_back({"device.left.unplug", at_ms(1500), at_ms(1500), Over::never});
  CHECK(recovery_in(run).state == State::never);
  CHECK_THAT(recovery_in(run).why, Catch::Contains("device.left.unplug lasts until the end"));
}

TEST_CASE("A run that ends too early to say gives no number, and says how long it must be", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults[0].to = at_ms(2800);
  CHECK(recovery_in(run).state == State::too_short);
  CHECK_THAT(recovery_in(run).why, Catch::Contains("must last at least 3.06667 s"));
  run.nominal.faults[0].to = at_ms(2600);  // one window is left, not two: there may not have been time enough to recover
  make_late(run, at_ms(2950), Duration{100'000});
  CHECK(recovery_in(run).state == State::too_short);
  CHECK_THAT(recovery_in(run).why, Catch::Contains("must last at least 3.13333 s"));
  CHECK(measure(run)["left.force.phase_locked"].count("recovered") == 0);
}

TEST_CASE("A fault that is over with a segment that never begins is not over", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults[0] = {"timing.changes", at_ms(1000), at_ms(2999), Over::with_segment};
  CHECK(recovery_in(run).state == State::too_short);
  CHECK_THAT(recovery_in(run).why, Catch::Contains("timing.changes is not over"));
}

TEST_CASE("A change is over when the first segment after it begins, a hitch when it ends", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults[0] = {"timing.changes", at_ms(1000), at_ms(1201), Over::with_segment};
  CHECK(recovery_in(run).faults_end == tick_time(synthetic::kSegmentRate, 37));
  run.nominal.faults[0].over = Over::after_segment;
  CHECK(recovery_in(run).faults_end == tick_time(synthetic::kSegmentRate, 38));
}

TEST_CASE("Without a judged window before the first fault there is nothing to compare with", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults[0].from = at_ms(400);  // the warm-up ends at 267 ms
  CHECK(recovery_in(run).state == State::no_calm);
  CHECK_THAT(recovery_in(run).why, Catch::Contains("nothing to compare with"));
  CHECK(measure(run)["left.force.phase_locked"].count("recovery_time") == 0);
}

TEST_CASE("What is usual is learned from eight segments, and where they are short from a quarter of a second",
          "[recovery]") {
  Nominal nominal;
  nominal.segment = Duration{50'000'000};
  CHECK(recovery_window(nominal).ns == 400'000'000);
  nominal.segment = Duration{2'400'000};
  CHECK(recovery_window(nominal).ns == 250'000'000);
}

TEST_CASE("Of several faults the first begins what is compared and the last what is waited for", "[recovery]") {
  RunRecord run = faulty_run();
  run.nominal.faults.push_back({"device.left.faults.1", at_ms(800), at_ms(900), Over::at_time});
  make_late(run, at_ms(850), Duration{100'000});
  CHECK(recovery_in(run).time_s() == 0);
  CHECK(recovery_in(run).faults_end == at_ms(1200));
}

// The three parts are set independently, at random times, with sizes far above or far below their limits.
TEST_CASE("The time of recovery is that of the last thing that was wrong, on random records", "[recovery][sweep]") {
  std::mt19937 random(1);
  const auto below = [&](std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint32_t>(n)); };
  for (std::uint64_t i = 0; i < testing::cases(1000); ++i) {
    RunRecord run = faulty_run(2);
    run.strategies.erase(run.strategies.begin(), run.strategies.begin() + 3);
    StrategyRecord& strategy = run.strategies.front();
    double expected_s = 0;
    for (std::int64_t wrong = below(4); wrong > 0; --wrong) {
      const RealTime time = at_ms(1000 + below(650));
      if (below(2) == 0) {
        std::size_t n = 0;
        while (strategy.steps[n].begin < time) ++n;
        strategy.devices[0].steps[n].read = StepRead::underrun;
        expected_s = std::max(expected_s, seconds(strategy.steps[n].begin - at_ms(1200)));
      } else {
        const std::size_t k = tick_at(time);
        const bool counts = below(2) == 0;
        strategy.devices[0].ticks[k].force_N[1] += counts ? 1 : 1e-4;
        if (counts) expected_s = std::max(expected_s, seconds(device_tick(k + 2) - at_ms(1200)));
      }
    }
    INFO("case " << i);
    const Recovery recovery = recovery_of(run, strategy, 0);
    REQUIRE(recovery.state == State::recovered);
    REQUIRE(recovery.time_s() == expected_s);
  }
}

}  // namespace evenstep
