// What is seen of a live run while it runs. Nothing here asserts how fast or how late: what was seen must be what was done.

#include "evenstep/harness/live_view.h"

#include <thread>

#include "../scenarios.h"
#include "catch.h"
#include "evenstep/harness/direct_shadow.h"
#include "evenstep/harness/live_figures.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Looks only after the loop has ended. The rings are large enough for these runs.
class LateViewer final : public LiveView {
 public:
  void begin(LoopWatch& loop, WallEpoch) override { loop_ = &loop; }
  void end() override {
    loop_->steps.take([&](const SeenStep& step) { steps.push_back(step); });
    loop_->ticks.take([&](const SeenTick& tick) { ticks.push_back(tick); });
    dropped = loop_->ticks.dropped() + loop_->steps.dropped();
    ++ends;
  }
  std::vector<SeenTick> ticks;
  std::vector<SeenStep> steps;
  std::uint64_t dropped = 0;
  int ends = 0;

 private:
  LoopWatch* loop_ = nullptr;
};

RunOutcome run_viewed(const Scenario& scenario, LiveView& view) {
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.control.view = &view;
  return run_scenario(scenario, options);
}

Scenario live_scenario(const std::string& strategy) {
  return read("paper/figure-1-spring.toml", {"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"0.7 s\"",
                                             "expect=[]", "run.live=\"" + strategy + "\""});
}

SeenTick tick_at(std::int64_t ms, std::int64_t late_ns, std::int64_t ran, double force_N) {
  SeenTick tick;
  tick.scheduled = RealTime{ms * kMs};
  tick.lateness = Duration{late_ns};
  tick.force_N = {force_N, 0, 0};
  tick.ran = ran;
  tick.guard = GuardState::armed;
  return tick;
}

SeenStep step_at(std::int64_t number, Duration force_margin, Duration sample_margin) {
  SeenStep step;
  step.number = number;
  step.mapped = true;
  step.force_margin = force_margin;
  step.tools[0].sample_margin = sample_margin;
  return step;
}

WatchedRun one_device() { return {"x", "phase_locked", Duration{4'000 * kMs}, {{"left", {1000, 1}, {}, 3, true}}}; }

}  // namespace

TEST_CASE("a run that is watched replays to the same hash, and what was seen is what it did") {
  LateViewer viewer;
  const RunOutcome outcome = run_viewed(live_scenario("phase_locked"), viewer);
  INFO(outcome.failure << outcome.repeat_difference);
  CHECK(outcome.exit == ExitCode::pass);
  CHECK(outcome.repeat_difference.empty());
  CHECK(viewer.ends == 1);
  CHECK(viewer.dropped == 0);
  const StrategyRecord& live = strategy(outcome.record, "phase_locked");
  const DeviceRecord& device = live.devices[0];
  REQUIRE(viewer.ticks.size() == device.ticks.size());
  for (std::size_t k = 0; k < viewer.ticks.size(); ++k) {
    REQUIRE(viewer.ticks[k].scheduled == device.ticks[k].at);
    REQUIRE(viewer.ticks[k].lateness == device.ticks[k].lateness);
    REQUIRE(to_vec3(viewer.ticks[k].sample.position_m) == device.ticks[k].position_m);
    REQUIRE(to_vec3(viewer.ticks[k].force_N) == device.ticks[k].force_N);
  }
  REQUIRE(viewer.steps.size() == live.steps.size());
  for (std::size_t n = 0; n < viewer.steps.size(); ++n) {
    REQUIRE(viewer.steps[n].number == static_cast<std::int64_t>(n));
    REQUIRE(to_vec3(viewer.steps[n].tools[0].hand_m) == device.steps[n].position_m);
    const RealTime deadline = device.interpolates ? live.steps[n].line_from : live.steps[n].emission;
    REQUIRE(viewer.steps[n].force_margin == deadline - live.steps[n].end);
  }
  const auto late = [&](UnderrunRow::Side side) {
    return std::count_if(live.underruns.begin(), live.underruns.end(),
                         [&](const UnderrunRow& row) { return row.side == side && row.policy != "gate"; });
  };
  CHECK(viewer.steps.back().late_reads == late(UnderrunRow::Side::interaction));
  CHECK(viewer.steps.back().late_forces == late(UnderrunRow::Side::force));
}

TEST_CASE("the shadow's hand is what direct reads, step for step, where direct is what runs") {
  const Scenario scenario = live_scenario("direct");
  LateViewer viewer;
  CHECK(run_viewed(scenario, viewer).exit == ExitCode::pass);
  DirectShadow shadow(scenario);
  for (const SeenTick& tick : viewer.ticks) shadow.add(tick);
  for (const SeenStep& step : viewer.steps) shadow.add(step);
  std::size_t ticks = 0, steps = 0;
  shadow.take(
      kNever, [&](const ShadowedTick& tick) { ticks += !tick.direct_N; },
      [&](const ShadowedStep& step) {
        ++steps;
        REQUIRE(to_vec3(step.direct_m[0]) == to_vec3(step.step.tools[0].hand_m));
      });
  CHECK(ticks == viewer.ticks.size());
  CHECK(steps == viewer.steps.size());
  CHECK(shadow.no_force(0) == "direct itself is what runs");
}

TEST_CASE("the shadow's hand is at 0 at a step that had no sample yet, as direct's is") {
  DirectShadow shadow(live_scenario("phase_locked"));
  SeenTick tick = tick_at(20, 9 * kMs, 1, 0);
  tick.sample.read_at = RealTime{29 * kMs};
  tick.sample.position_m = {0.00002, 0, 0};
  shadow.add(tick);
  for (const bool sampled : {false, true}) {
    SeenStep step = step_at(0, {}, {});
    step.tools[0].sampled = sampled;
    step.tools[0].newest = RealTime{sampled ? 29 * kMs : 0};
    step.end = RealTime{sampled ? 31 * kMs : 12 * kMs};
    shadow.add(step);
  }
  std::vector<double> hands_m;
  shadow.take(
      kNever, [](const ShadowedTick&) {}, [&](const ShadowedStep& step) { hands_m.push_back(step.direct_m[0].x); });
  CHECK(hands_m == std::vector<double>{0, 0.00002});
}

TEST_CASE("the shadow's force is the scene's answer to the newest sample, from the end of the step on") {
  DirectShadow shadow(live_scenario("phase_locked"));  // a spring of 200 N/m
  CHECK(shadow.no_force(0).empty());
  for (std::int64_t k = 0; k < 10; ++k) {
    SeenTick tick = tick_at(k, 1000, k + 1, 0);
    tick.sample.read_at = RealTime{k * kMs + 1000};
    tick.sample.position_m = {0.001 * static_cast<double>(k), 0, 0};
    tick.sample.fresh = true;
    shadow.add(tick);
  }
  SeenStep step = step_at(0, {}, {});
  step.tools[0].newest = RealTime{2 * kMs + 1000};
  step.tools[0].hand_m = {0.0005, 0, 0};
  step.end = RealTime{5 * kMs};
  shadow.add(step);
  std::vector<double> forces;
  shadow.take(
      RealTime{7 * kMs + 1001}, [&](const ShadowedTick& tick) { forces.push_back(tick.direct_N.value().x); },
      [&](const ShadowedStep& seen) { CHECK(seen.direct_m[0].x == 0.002); });
  REQUIRE(forces.size() == 8);
  for (std::size_t k = 0; k < 8; ++k) CHECK(forces[k] == Approx(k < 5 ? 0 : -0.4));
  shadow.take(
      kNever, [&](const ShadowedTick&) { forces.push_back(0); }, [](const ShadowedStep&) { FAIL("taken twice"); });
  CHECK(forces.size() == 10);
}

TEST_CASE("a tissue's shadow has a hand and no force") {
  const DirectShadow shadow(read("paper/figure-1.toml", small_tissue("cpu-double")));
  CHECK(shadow.no_force(0) == "direct's force would need a second solver of this scene; report.html has it after the run");
}

TEST_CASE("what nobody comes for in time is dropped, the oldest first, and counted") {
  SeenRing<int> ring(8);
  std::vector<int> seen;
  const auto take = [&] { ring.take([&](int value) { seen.push_back(value); }); };
  for (int i = 0; i < 20; ++i) ring.push(i);
  take();
  CHECK(seen == std::vector<int>{12, 13, 14, 15, 16, 17, 18, 19});
  CHECK(ring.dropped() == 12);
  take();
  CHECK(seen.size() == 8);
  ring.push(20);
  take();
  CHECK(seen.back() == 20);
  CHECK(ring.dropped() == 12);
}

TEST_CASE("a writer that never waits, and a reader on another thread: each entry is seen once, in order, or counted") {
  constexpr int kEntries = 100'000;
  SeenRing<std::array<int, 9>> ring(16);
  std::thread writer([&] {
    for (int i = 0; i < kEntries; ++i) {
      std::array<int, 9> entry;
      entry.fill(i);
      ring.push(entry);
    }
  });
  int seen = 0, last = -1;
  bool whole = true;
  const auto take = [&] {
    ring.take([&](const std::array<int, 9>& entry) {
      whole = whole && entry[0] > last && std::count(entry.begin(), entry.end(), entry[0]) == 9;
      last = entry[0];
      ++seen;
    });
  };
  while (last != kEntries - 1) take();
  writer.join();
  CHECK(whole);
  CHECK(static_cast<std::uint64_t>(seen) + ring.dropped() == kEntries);
}

TEST_CASE("figures: quantiles of what was seen since the last time, counts that miss nothing that was dropped") {
  const WatchedRun run = one_device();
  LiveFigures figures(run);
  for (std::int64_t k = 0; k < 100; ++k) figures.add(tick_at(k, (k + 1) * 1000, k + 1, 0.5));
  figures.add(step_at(0, Duration{3 * kMs}, Duration{2 * kMs}));
  LiveSnapshot first = figures.take(RealTime{100 * kMs}, 0);
  CHECK(first.left == Duration{3'900 * kMs});
  CHECK(first.span == Duration{100 * kMs});
  CHECK(first.last.counts.ticks == 100);
  CHECK(first.last.counts.steps == 1);
  CHECK(first.last.counts.missed == 0);
  CHECK(first.lateness_p50 == Duration{50'000});
  CHECK(first.lateness_p99 == Duration{99'000});
  CHECK(first.last.lateness_max == Duration{100'000});
  CHECK(first.last.least_margin == Duration{2 * kMs});
  CHECK(first.devices[0].force_N == 0.5);

  // Ticks 100 to 149 ran, but were dropped before anybody saw them. Ticks 160 and 161 never ran.
  for (std::int64_t k = 150; k < 160; ++k) figures.add(tick_at(k, 7, k + 1, 1));
  SeenTick after = tick_at(162, 2 * kMs, 161, 3);
  after.guard = GuardState::cut_speed;
  after.saturated.add(SaturationCause::clamp);
  figures.add(after);
  figures.add(tick_at(163, 7, 162, 3));
  SeenStep late = step_at(7, Duration{-kMs}, Duration{5 * kMs});
  late.late_reads = 2;
  late.late_forces = 1;
  figures.add(late);
  const LiveSnapshot second = figures.take(RealTime{164 * kMs}, 50);
  CHECK(second.last.counts.ticks == 62);
  CHECK(second.last.counts.missed == 2);
  CHECK(second.last.counts.steps == 7);
  CHECK(second.last.counts.underruns() == 3);
  CHECK(second.last.least_margin == Duration{-kMs});
  CHECK(second.last.clamped == 1);
  CHECK(second.lateness_p50 == Duration{7});
  CHECK(second.whole.counts.ticks == 162);
  CHECK(second.whole.lateness_max == Duration{2 * kMs});
  CHECK(second.whole.least_margin == Duration{-kMs});
  CHECK(second.devices[0].guard == GuardState::cut_speed);  // the worst state since the last snapshot, although it has ended
  CHECK(second.dropped == 50);

  CHECK(figures.take(RealTime{3'999 * kMs}, 50).last.counts.missed == 0);  // ticks that may still come
  const LiveSnapshot none = figures.take(RealTime{5'000 * kMs}, 50);
  CHECK(none.last.counts.missed == 4'000 - 164);  // of the run's four seconds, to its end
  CHECK(none.whole.counts.missed == 2 + 4'000 - 164);
  CHECK(none.left == Duration{0});
  CHECK(none.last.counts.ticks == 0);
  CHECK(none.lateness_p99 == Duration{0});
  CHECK_FALSE(none.last.least_margin);
  CHECK_FALSE(none.devices[0].guard);
  CHECK(none.devices[0].force_N == 3);
  CHECK(none.whole.counts.ticks == 162);
}
