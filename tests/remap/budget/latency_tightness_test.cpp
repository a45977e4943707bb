// The budget, compared with a replay that knows nothing of its formulas: it lists all ticks and searches them.

#include <algorithm>

#include "../schedules.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

std::vector<RealTime> ticks_around(const std::vector<MappedStep>& steps, SamplingGrid grid) {
  RealTime low = steps[0].begin, high = steps[0].begin;
  for (const MappedStep& step : steps) {
    low = std::min({low, step.begin, step.slot});
    high = std::max({high, step.begin, step.slot});
  }
  const Duration margin{200'000'000};
  std::vector<RealTime> ticks;
  std::int64_t k = first_tick_at_or_after(grid.rate, low - margin, grid.origin);
  for (; tick_time(grid.rate, k, grid.origin) <= high + margin; ++k) ticks.push_back(tick_time(grid.rate, k, grid.origin));
  return ticks;
}

/// The number of steps for which no tick lies in [R, S].
std::int64_t replay_interaction(const std::vector<MappedStep>& steps, SamplingGrid grid, Duration lead) {
  const std::vector<RealTime> ticks = ticks_around(steps, grid);
  std::int64_t missed = 0;
  for (const MappedStep& step : steps) {
    const auto first = std::lower_bound(ticks.begin(), ticks.end(), step.slot - lead);
    missed += first == ticks.end() || *first > step.begin;
  }
  return missed;
}

/// The number of steps whose force is not there when it is due: at F(n) or, with interpolation, at the begin of the interval
/// before it.
std::int64_t replay_forces(const std::vector<MappedStep>& steps, Duration lead, Duration latency, Emission emission) {
  std::vector<RealTime> due;
  for (const MappedStep& step : steps) {
    const RealTime wanted = step.slot - lead + latency;
    due.push_back(due.empty() ? wanted : std::max(wanted, due.back() + Duration{1}));
  }
  std::int64_t late = 0;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const std::size_t from = emission == Emission::linear && n > 0 ? n - 1 : n;
    late += steps[n].end > due[from];
  }
  return late;
}

/// A phase at which the sample for the step that sets the lead comes as late as possible: with a lead 1 ns too small, a tick
/// comes 1 ns before R, and the longest gap of the grid follows.
SamplingGrid worst_phase(Rate rate, const MappedStep& culprit, Duration lead) {
  std::int64_t k = 0;
  while (instant_ns(rate, k + 1) - instant_ns(rate, k) < period_ceil(rate).ns) ++k;
  const RealTime read = culprit.slot - (lead - Duration{1});
  return {rate, read - Duration{1} - Duration{instant_ns(rate, k)}};
}

const MappedStep& step_of(const std::vector<MappedStep>& steps, std::int64_t n) {
  return *std::find_if(steps.begin(), steps.end(), [&](const MappedStep& s) { return s.step == n; });
}

}  // namespace

TEST_CASE("c and L are tight at any phase and at this phase, by replay: 2500 traces, 3 maps, 5 rates") {
  // h = 0.25, 1, 2 and 3.7 ms, and 900 Hz, whose period is not a whole number of ns.
  const Rate rates[]{{4000, 1}, {1000, 1}, {500, 1}, {10'000, 37}, {900, 1}};
  std::int64_t judged = 0, stepped_back = 0;
  for (std::uint64_t seed = 0; seed < 2500; ++seed) {
    Draw draw(seed);
    const Schedule schedule = random_schedule(draw, 6);
    const Rate rate = rates[draw.between(0, 4)];
    const SamplingGrid grid{rate, RealTime{draw.between(0, period_ceil(rate).ns - 1)}};
    const Emission emission = draw.between(0, 1) == 0 ? Emission::hold : Emission::linear;
    std::vector<Placed> placed;
    switch (draw.between(0, 2)) {
      case 0:
        placed = place(PaperMap({}, {}, 0.3), schedule);
        break;
      case 1:
        placed = place(PhaseLockedMap({}, {}), schedule);
        break;
      default:
        placed = place(EvenMap(schedule[0].begin, {draw.between(100, 2000), 1}, {}, {}), schedule);
    }
    const std::vector<MappedStep> steps = mapped_steps(placed);
    if (steps.empty()) continue;
    ++judged;
    for (std::size_t i = 1; i < steps.size(); ++i) stepped_back += steps[i].slot <= steps[i - 1].slot;
    INFO("seed " << seed);

    const LatencyBudget here = least_latency_this_phase(steps, std::span(&grid, 1), emission);
    REQUIRE(replay_interaction(steps, grid, here.lead) == 0);
    REQUIRE(replay_interaction(steps, grid, here.lead - Duration{1}) > 0);
    REQUIRE(replay_forces(steps, here.lead, here.latency, emission) == 0);
    REQUIRE(replay_forces(steps, here.lead, here.latency - Duration{1}, emission) > 0);

    const LatencyBudget any = least_latency_any_phase(steps, std::span(&grid, 1), emission);
    REQUIRE(any.latency >= here.latency);
    REQUIRE(replay_interaction(steps, grid, any.lead) == 0);
    const SamplingGrid worst = worst_phase(rate, step_of(steps, any.lead_culprit), any.lead);
    REQUIRE(replay_interaction(steps, worst, any.lead) == 0);
    REQUIRE(replay_interaction(steps, worst, any.lead - Duration{1}) > 0);
    REQUIRE(replay_forces(steps, any.lead, any.latency, emission) == 0);
    REQUIRE(replay_forces(steps, any.lead, any.latency - Duration{1}, emission) > 0);

    REQUIRE(count_late_forces(steps, any.lead, any.latency, emission) == 0);
    REQUIRE(count_late_forces(steps, any.lead, any.latency - Duration{1}, emission) > 0);

    // The predicted counts agree with the replay for other leads and latencies, too.
    const Duration lead = any.lead - Duration{draw.between(0, 3'000'000)};
    const Duration latency = any.latency - Duration{draw.between(0, 5'000'000)};
    REQUIRE(count_interaction_underruns(steps, grid, lead) == replay_interaction(steps, grid, lead));
    REQUIRE(count_late_forces(steps, lead, latency, emission) == replay_forces(steps, lead, latency, emission));
  }
  CHECK(judged >= 2000);
  CHECK(stepped_back > 100);  // the repair of emission times was exercised
}
