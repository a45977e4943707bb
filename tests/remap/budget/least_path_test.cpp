// The bounds of every trace, compared with brute force at the bound and 1 ns below it.
#include "../schedules.h"
#include "catch.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/step_windows.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// Is there a path that never steps back and keeps to E_n - L <= R(n) <= S_n - d? It is enough to try the earliest one.
bool path_exists(const std::vector<StepTimes>& steps, Duration latency, Duration sampling) {
  std::optional<RealTime> before;
  for (const StepTimes& step : steps) {
    RealTime read = step.end - latency;
    if (before) read = std::max(read, *before);
    if (read > step.begin - sampling) return false;
    before = read;
  }
  return true;
}

/// Does a line a + n rise/run fit, exactly? Computed from the bounds of its offset, in units of 1/run.
bool line_exists(const std::vector<StepTimes>& steps, std::int64_t rise, std::int64_t run, Duration latency,
                 Duration sampling) {
  __int128 least = 0, most = 0;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const __int128 slots = static_cast<__int128>(n) * rise;
    const __int128 low = static_cast<__int128>((steps[n].end - latency).ns) * run - slots;
    const __int128 high = static_cast<__int128>((steps[n].begin - sampling).ns) * run - slots;
    least = n == 0 ? low : std::max(least, low);
    most = n == 0 ? high : std::min(most, high);
  }
  return least <= most;
}

/// A line that fits can be turned until it touches two ends or two begins. So no other slopes need be tried.
bool any_line_exists(const std::vector<StepTimes>& steps, Duration latency, Duration sampling) {
  for (std::size_t a = 0; a < steps.size(); ++a) {
    for (std::size_t b = a + 1; b < steps.size(); ++b) {
      const auto run = static_cast<std::int64_t>(b - a);
      if (line_exists(steps, (steps[b].end - steps[a].end).ns, run, latency, sampling)) return true;
      if (line_exists(steps, (steps[b].begin - steps[a].begin).ns, run, latency, sampling)) return true;
    }
  }
  return false;
}

/// Steps that overlap: a step of another queue begins before the one before has ended.
std::vector<StepTimes> overlapping(Draw& draw) {
  std::vector<StepTimes> steps(static_cast<std::size_t>(draw.between(1, 40)));
  RealTime begin{};
  for (StepTimes& step : steps) {
    begin = begin + Duration{draw.between(0, 1'000)};
    step = {begin, begin + Duration{draw.between(0, 5'000)}};
  }
  return steps;
}

}  // namespace

TEST_CASE("the least path of none and of one step") {
  CHECK(least_path({}).latency.ns == 0);
  CHECK(least_path({}).latency_culprit == -1);
  const std::vector<StepTimes> one{{RealTime{5}, RealTime{12}}};
  CHECK(least_path(one).latency.ns == 7);
  CHECK(least_path(one).latency_culprit == 0);
}

TEST_CASE("a path exists at the least path's latency and none 1 ns below in 8000 traces of which half overlap") {
  for (std::uint64_t seed = 0; seed < 8000; ++seed) {
    Draw draw(seed + 7);
    const std::vector<StepTimes> steps = seed % 2 == 0 ? flat(random_schedule(draw, draw.between(1, 6))) : overlapping(draw);
    if (steps.empty()) continue;
    const Duration sampling{draw.between(0, 2'000'000)};
    const LeastPath least = least_path(steps);
    INFO("seed " << seed);
    REQUIRE(path_exists(steps, least.latency + sampling, sampling));
    REQUIRE_FALSE(path_exists(steps, least.latency + sampling - Duration{1}, sampling));
    // The end of the culprit decides the latency: without that end the others need no more.
    std::vector<StepTimes> without = steps;
    StepTimes& culprit = without[static_cast<std::size_t>(least.latency_culprit)];
    culprit.end = culprit.begin;
    REQUIRE(least_path(without).latency <= least.latency);
    REQUIRE(least.latency >= steps[static_cast<std::size_t>(least.latency_culprit)].end -
                                 steps[static_cast<std::size_t>(least.latency_culprit)].begin);
  }
}

TEST_CASE("the taut string exists from the least path's latency on and no sooner in 1000 traces") {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Draw draw(seed + 1007);
    const std::vector<StepTimes> steps = flat(random_schedule(draw, draw.between(1, 6)));
    if (steps.empty()) continue;
    const Duration sampling{draw.between(0, 2'000'000)};
    const Duration least = least_path(steps).latency + sampling;
    REQUIRE_FALSE(taut_string(steps, least, sampling).infeasible_step);
    REQUIRE(taut_string(steps, least - Duration{1}, sampling).infeasible_step ==
            static_cast<std::size_t>(least_path(steps).latency_culprit));
    REQUIRE(best_line(steps).latency + sampling >= least);
  }
}

TEST_CASE("a line fits at the best line's latency and none 1 ns below and it touches both culprits in 2000 traces") {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Draw draw(seed + 77);
    std::vector<StepTimes> steps = flat(random_schedule(draw, 3));
    if (steps.size() > 25) steps.resize(25);
    if (steps.size() < 2) continue;
    const Duration sampling{draw.between(0, 2'000'000)};
    const BestLine line = best_line(steps);
    INFO("seed " << seed);
    REQUIRE(any_line_exists(steps, line.latency + sampling, sampling));
    REQUIRE_FALSE(any_line_exists(steps, line.latency + sampling - Duration{1}, sampling));
    const auto at = [&](std::int64_t n) { return steps[static_cast<std::size_t>(n)]; };
    const double slots_ns = line.slot_ns * static_cast<double>(line.latency_culprit - line.lead_culprit);
    const Duration between = at(line.latency_culprit).end - at(line.lead_culprit).begin;
    REQUIRE(std::abs(static_cast<double>(between.ns) - slots_ns - static_cast<double>(line.latency.ns)) <= 1 + 1e-6);
  }
}

TEST_CASE("interpolated forces take the next end so a periodic line needs one slot more") {
  std::vector<StepTimes> steps = flat(Periodic{}.schedule(30));
  const Duration held = best_line(steps).latency;
  const std::vector<StepTimes> before = steps;
  interpolate(steps);
  for (std::size_t n = 0; n + 1 < steps.size(); ++n) REQUIRE(steps[n].end == before[n + 1].end);
  CHECK(steps.back().end == before.back().end);
  CHECK(std::abs((best_line(steps).latency - held).ns - 2'222'222) <= 2);
}

TEST_CASE("windows hold every step up to the last whole one and each lasts its length") {
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Draw draw(seed + 5);
    const std::vector<StepTimes> steps = flat(random_schedule(draw, 40));
    if (steps.empty()) continue;
    const Duration length{draw.between(1'000'000, 300'000'000)};
    const auto windows = step_windows(std::span<const StepTimes>(steps), length);
    REQUIRE_FALSE(windows.empty());
    std::size_t expected = 0;
    for (const auto& [from, to] : windows) {
      REQUIRE(from == expected);
      REQUIRE(to > from);
      REQUIRE(steps[to - 1].begin < steps[from].begin + length);
      if (to < steps.size()) REQUIRE(steps[to].begin >= steps[from].begin + length);
      expected = to;
    }
    if (expected < steps.size())
      REQUIRE(steps.back().begin < steps[expected].begin + length);
    else
      REQUIRE(windows.size() == 1);
  }
}
