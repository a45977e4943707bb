// What a game's loop needs of its maps: the least latency of `clocked` beside that of `phase_locked`.
#include <fmt/format.h>

#include <iostream>

#include "evenstep/remap/latency_budget.h"
#include "evenstep/remap/maps/clocked_map.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/velocity_jump.h"
#include "evenstep/scheduler/random.h"
#include "timing_checks.h"

namespace evenstep {
namespace {

struct Needs {
  double latency_ms = 0, jump = 0;  ///< least latency at any phase of 1 kHz, held; largest jump, in step sizes
};

/// Plays 20 s of a loop through a map with lead 0.
Needs needs_of(const ProgrammedTiming& timing, SlotMap& map) {
  std::vector<MappedStep> steps;
  const auto frames = make_programmed_timing(timing);
  std::int64_t n = 0;
  for (SegmentTiming frame; frames->next(frame) && frame.begin < RealTime{20'000 * ms};) {
    map.boundary(n, frame.begin);
    for (const Interval& step : frame.steps) {
      if (const auto t = frame.simulated_at(step)) map.simulated(*t);
      const Slot slot = map.read(n, step.begin);
      map.emission(n, step.end);
      if (slot.kind == SlotKind::mapped) steps.push_back({n, step.begin, step.end, slot.read});
      ++n;
    }
  }
  const SamplingGrid device{{1'000, 1}, RealTime{0}};
  VelocityJump jump(RealTime{1'000 * ms});
  jump.add(steps);
  return {static_cast<double>(least_needs_any_phase(steps, {&device, 1}, Emission::hold).latency.ns) / 1e6,
          static_cast<double>(jump.most_ns()) / static_cast<double>(instant_ns(timing.accumulator->step_rate, 1))};
}

Needs clocked_needs(const ProgrammedTiming& timing, bool at_once) {
  Clocked clock{.step_rate = timing.accumulator->step_rate};
  if (!at_once) clock.most = {instant_ns(clock.step_rate, 1) * 7 / 100};
  ClockedMap map(clock, {}, Duration{});
  return needs_of(timing, map);
}

/// Frames of so many Hz; drawings of 4 ms +- 25 %, steps of 0.5 ms (0.3 ms where there are many), refreshes up to 0.4 ms
/// late.
ProgrammedTiming game_loop(std::int64_t refresh_Hz, std::int64_t steps_Hz) {
  return {.segment = {refresh_Hz, 1},
          .visualization = {4 * ms},
          .steps = {1},
          .step = Duration{steps_Hz < 500 ? 500'000 : 300'000},
          .order = SegmentOrder::steps_first,
          .visualization_variation = 0.25,
          .visualization_law = JitterLaw::uniform,
          .paced = true,
          .accumulator = Accumulator{.step_rate = {steps_Hz, 1}, .refresh_jitter = {400'000}}};
}

TEST_CASE("print the latencies of loops with every map", "[.print-loops]") {
  const auto print = [](const char* name, const ProgrammedTiming& timing) {
    PhaseLockedMap locked({}, Duration{}, 2.0);
    const Needs slew = clocked_needs(timing, false), jump = clocked_needs(timing, true), other = needs_of(timing, locked);
    std::cout << fmt::format(
        "{:30} clocked slew {:6.2f} ms {:.3f}  jump {:6.2f} ms {:.3f}  phase_locked {:6.2f} ms {:.3f}\n", name,
        slew.latency_ms, slew.jump, jump.latency_ms, jump.jump, other.latency_ms, other.jump);
  };
  for (const auto& [refresh, steps] : {std::pair(60, 90), {72, 90}, {60, 50}, {60, 500}, {144, 60}})
    print(fmt::format("{}, {} Hz", refresh, steps).c_str(), game_loop(refresh, steps));
  ProgrammedTiming hitches = game_loop(60, 90);
  hitches.hitch = Hitch{{2'000 * ms}, {49 * ms}};
  print("60, 90 Hz, hitches", hitches);
  hitches.accumulator->max_steps = 3;
  print("60, 90 Hz, hitches, 3 steps", hitches);
}

TEST_CASE(
    "clocked needs 12.5, 12.5, 15.2, 15.4 and 7.4 ms for loops that phase_locked needs up to 51 ms for, without a jump") {
  // Of an independent prototype on schedules of the same kind. Its draws were others, and its numbers have one digit.
  struct Row {
    std::int64_t refresh_Hz, steps_Hz;
    double clocked_ms, phase_locked_ms;
  };
  for (const auto& [refresh_Hz, steps_Hz, clocked_ms, phase_locked_ms] :
       {Row{60, 90, 12.5, 19.7}, Row{72, 90, 12.5, 18.5}, Row{60, 50, 15.2, 24.6}, Row{60, 500, 15.4, 16.6},
        Row{144, 60, 7.4, 50.9}}) {
    INFO(refresh_Hz << ", " << steps_Hz << " Hz");
    const ProgrammedTiming timing = game_loop(refresh_Hz, steps_Hz);
    const Needs needs = clocked_needs(timing, false);
    CHECK(std::abs(needs.latency_ms - clocked_ms) <= 0.1 + 0.05);
    CHECK(needs.jump < 1e-6);
    PhaseLockedMap locked({}, Duration{}, 2.0);
    CHECK(needs_of(timing, locked).latency_ms == Approx(phase_locked_ms).epsilon(0.05));
  }
}

/// Without drops the slots are t plus a constant, so the least latency is the range of S(n) - t(n) over all steps, from the
/// begin of one to the end of another, plus the device's period.
TEST_CASE("the least latency of clocked is the range of the loop's lag, plus a period, in 1 000 loops", "[sweep]") {
  for (std::uint64_t seed = 0; seed < 1'000; ++seed) {
    const RandomStream random(seed, "loops");
    const auto draw = [&](std::uint64_t n, std::int64_t least, std::int64_t most) {
      return least + static_cast<std::int64_t>(random.below(n, static_cast<std::uint64_t>(most - least + 1)));
    };
    ProgrammedTiming timing = game_loop(draw(0, 30, 150), draw(1, 20, 600));
    timing.seed = seed;
    if (draw(2, 0, 1) == 0) timing.hitch = Hitch{{2'000 * ms}, {draw(3, 5, 60) * ms}};
    if (draw(4, 0, 1) == 0) timing.order = SegmentOrder::visualization_first;
    if (draw(5, 0, 1) == 0) timing.accumulator->jitter_fix = {instant_ns(timing.accumulator->step_rate, 1) / 2};
    const auto frames = make_programmed_timing(timing);
    std::int64_t least_ns = INT64_MAX, most_ns = INT64_MIN;
    for (SegmentTiming frame; frames->next(frame) && frame.begin < RealTime{20'000 * ms};) {
      for (const Interval& step : frame.steps) {
        const std::int64_t t_ns = frame.simulated_at(step)->ns;
        least_ns = std::min(least_ns, step.begin.ns - t_ns);
        most_ns = std::max(most_ns, step.end.ns - t_ns);
      }
    }
    const Needs needs = clocked_needs(timing, false);
    REQUIRE(needs.latency_ms == Approx(static_cast<double>(most_ns - least_ns) / 1e6 + 1).margin(2e-6));
    REQUIRE(needs.jump * static_cast<double>(instant_ns(timing.accumulator->step_rate, 1)) <= 1.001);
  }
}

TEST_CASE("where a loop drops time, following at once needs less latency, and following by 7 % a step jumps by no more") {
  ProgrammedTiming timing = game_loop(60, 90);
  timing.hitch = Hitch{{2'000 * ms}, {49 * ms}};
  const double whole_ms = clocked_needs(timing, true).latency_ms;
  timing.accumulator->max_steps = 3;
  const Needs at_once = clocked_needs(timing, true), slowly = clocked_needs(timing, false);
  CHECK(at_once.latency_ms < 0.6 * whole_ms);
  CHECK(at_once.jump >= 1);
  CHECK(slowly.latency_ms < whole_ms + 0.01);
  CHECK(slowly.jump < 0.0701);
}

}  // namespace
}  // namespace evenstep
