// A cycle that exists is found as it is, and none is found where there is none.
#include "evenstep/remap/step_cycle.h"

#include "catch.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr std::int64_t us = 1'000, ms = 1'000'000;

/// The indices of the steps that begin a segment of the schedule, except the first.
std::vector<std::size_t> boundaries_of(const Schedule& schedule) {
  std::vector<std::size_t> boundaries;
  std::size_t n = 0;
  for (const Segment& segment : schedule) {
    if (n > 0 && !segment.steps.empty()) boundaries.push_back(n);
    n += segment.steps.size();
  }
  return boundaries;
}

/// Steps whose gaps are drawn one by one, so that they have no rhythm.
template <class Gap>
std::vector<StepTimes> gapped(Draw& draw, std::size_t count, Gap gap) {
  std::vector<StepTimes> steps;
  RealTime now{};
  for (std::size_t n = 0; n < count; ++n) {
    const RealTime begin = now + Duration{gap(draw)};
    now = begin + Duration{1 * ms};
    steps.push_back({begin, now});
  }
  return steps;
}

}  // namespace

TEST_CASE("a periodic cycle of 2 to 200 steps and pauses of half a step to 100 steps is found exactly") {
  for (const std::int32_t steps : {2, 3, 15, 60, 200}) {
    for (const double in_steps : {0.5, 1.0, 5.0, 100.0}) {
      const double step_ns = 33'333'333 / (steps + in_steps);
      const Periodic periodic{.visualization = {static_cast<std::int64_t>(in_steps * step_ns)}, .steps = steps};
      const Schedule schedule = periodic.schedule(40);
      const StepCycle cycle = find_cycle(flat(schedule));
      INFO(steps << " steps, visualization " << in_steps << " steps long: " << cycle.reason);
      REQUIRE(cycle.found);
      CHECK(cycle.boundaries == boundaries_of(schedule));
      CHECK(cycle.steps_per_segment == steps);
      CHECK(cycle.least_steps == steps);
      CHECK(cycle.most_steps == steps);
      CHECK(cycle.segments == 38);  // the first and the last one are open on one side
      CHECK(std::abs(cycle.period.ns - 33'333'333) <= 1);
      CHECK(cycle.period_variation < 1e-7);
      CHECK(std::abs((cycle.pause - periodic.visualization).ns) <= 1);
      CHECK(cycle.longest_gap.ns == 0);
      CHECK(cycle.confidence == 1);
      CHECK(cycle.regularity == Approx(1));
      CHECK(cycle.shuffles_as_regular == 0);
    }
  }
}

TEST_CASE("it does not matter where in a cycle a list begins") {
  const std::vector<StepTimes> all = flat(Periodic{}.schedule(40));
  for (std::size_t from = 0; from < 15; ++from) {
    const StepCycle cycle = find_cycle(std::span(all).subspan(from));
    REQUIRE(cycle.found);
    REQUIRE(cycle.boundaries.front() == 15 - from);
    REQUIRE(cycle.steps_per_segment == 15);
  }
}

TEST_CASE("no cycle is hidden by jitter of 1 to 30 % and gaps of the driver in 300 traces") {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Draw draw(seed);
    Schedule schedule = jittered(draw, 0.01 * static_cast<double>(1 + seed % 30), 60);
    for (Segment& segment : schedule) {
      for (StepTimes& step : segment.steps) step.end = step.end - Duration{draw.between(0, 75 * us)};
    }
    const StepCycle cycle = find_cycle(flat(schedule));
    INFO("seed " << seed << ": " << cycle.reason);
    REQUIRE(cycle.found);
    REQUIRE(cycle.boundaries == boundaries_of(schedule));
    REQUIRE(cycle.confidence == 1);
    REQUIRE(cycle.longest_gap.ns <= 75 * us);
  }
}

TEST_CASE("N drawn from 14 to 16 is a cycle and the confidence is the share of the commonest N") {
  Draw draw(4);
  Schedule schedule;
  for (std::int64_t k = 0; k < 300; ++k)
    schedule.push_back(Periodic{.steps = static_cast<std::int32_t>(draw.between(14, 16))}.segment(k));
  const StepCycle cycle = find_cycle(flat(schedule));
  REQUIRE(cycle.found);
  CHECK(cycle.boundaries == boundaries_of(schedule));
  CHECK(cycle.least_steps == 14);
  CHECK(cycle.most_steps == 16);
  CHECK(cycle.confidence > 0.33);
  CHECK(cycle.confidence < 0.45);
  CHECK(cycle.regularity > 0.9);
}

TEST_CASE("a visualization dropped now and then leaves a cycle with segments of twice as many steps") {
  Draw draw(5);
  Schedule schedule;
  for (std::int64_t k = 0; k < 400; ++k) {
    const bool dropped = draw.between(0, 19) == 0;
    schedule.push_back(Periodic{.visualization = {dropped ? 0 : 11'100'000}, .idle = {dropped ? 0 : 1}}.segment(k));
  }
  const StepCycle cycle = find_cycle(flat(schedule));
  REQUIRE(cycle.found);
  CHECK(cycle.steps_per_segment == 15);
  CHECK(cycle.most_steps >= 30);
  CHECK(cycle.confidence > 0.9);
}

TEST_CASE("a hang does not hide the cycle and a stray pause in one segment does not move the others") {
  std::vector<StepTimes> steps = flat(Periodic{}.schedule(100));
  const auto push_back = [&](std::size_t from, Duration by) {
    for (std::size_t n = from; n < steps.size(); ++n) steps[n] = {steps[n].begin + by, steps[n].end + by};
  };
  push_back(15 * 20, {2000 * ms});
  push_back(15 * 50 + 7, {2 * ms});
  const StepCycle cycle = find_cycle(steps);
  REQUIRE(cycle.found);
  CHECK(cycle.steps_per_segment == 15);
  CHECK(cycle.confidence == 1);
  CHECK(cycle.longest_gap.ns == 2 * ms);
}

TEST_CASE("a longer pause in every tenth segment is part of the cycle of the shorter ones") {
  Schedule schedule;
  RealTime now{};
  for (std::int64_t k = 0; k < 400; ++k) {
    now = now + Duration{k % 10 == 0 ? 60 * ms : 10 * ms};
    schedule.push_back({now, {}});
    for (std::int32_t i = 0; i < 15; ++i) {
      schedule.back().steps.push_back({now, now + Duration{1 * ms}, k, i});
      now = now + Duration{1 * ms};
    }
  }
  const StepCycle cycle = find_cycle(flat(schedule));
  REQUIRE(cycle.found);
  CHECK(cycle.steps_per_segment == 15);
  CHECK(cycle.pause.ns == 10 * ms);
}

TEST_CASE("there is no cycle in steps back to back evenly apart or too few") {
  const auto reason = [](const std::vector<StepTimes>& steps) {
    const StepCycle cycle = find_cycle(steps);
    CHECK_FALSE(cycle.found);
    CHECK(cycle.boundaries.empty());
    return cycle.reason;
  };
  Draw draw(1);
  CHECK(reason({}) == "fewer than two steps");
  CHECK(reason({{RealTime{0}, RealTime{1}}}) == "fewer than two steps");
  CHECK(reason(gapped(draw, 500, [](Draw&) { return 0; })) == "no pause between steps stands out from the others");
  CHECK(reason(gapped(draw, 500, [](Draw&) { return 3 * ms; })) == "no pause between steps stands out from the others");
  CHECK(reason(gapped(draw, 500, [](Draw& d) { return d.between(0, 75 * us); })) ==
        "no pause between steps stands out from the others");
  CHECK(reason(flat(Periodic{}.schedule(16))).find("fewer than 16 segments") == 0);
}

TEST_CASE("pauses that fall anywhere are no cycle and of 3000 such traces at most 3 are mistaken") {
  // After each step a long pause comes with a probability of 1/2 to 1/50. The lengths are alike or differ by decades.
  int found = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    Draw draw(seed + 9);
    const std::int64_t rarely = draw.between(2, 50);
    const bool alike = draw.between(0, 1) == 0;
    const std::vector<StepTimes> steps = gapped(draw, 1500, [&](Draw& d) {
      if (d.between(1, rarely) != 1) return d.between(0, 50 * us);
      return alike ? 10 * ms : d.between(1, 200) * d.between(1, 200) * 10 * us;
    });
    const StepCycle cycle = find_cycle(steps);
    found += cycle.found;
  }
  CHECK(found <= 3);
}

TEST_CASE("steps per segment drawn evenly from 1 to 40 are no cycle") {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Draw draw(seed + 40);
    Schedule schedule;
    for (std::int64_t k = 0; k < 200; ++k)
      schedule.push_back(Periodic{.steps = static_cast<std::int32_t>(draw.between(1, 40))}.segment(k));
    const StepCycle cycle = find_cycle(flat(schedule));
    INFO("seed " << seed << " regularity " << cycle.regularity);
    REQUIRE_FALSE(cycle.found);
  }
}

TEST_CASE("the cycle found does not change with the origin of time and scales with it") {
  const StepCycle cycle = find_cycle(flat(Periodic{}.schedule(40)));
  std::vector<StepTimes> steps = flat(Periodic{}.schedule(40));
  for (StepTimes& step : steps) step = {RealTime{3 * step.begin.ns - 5'000 * ms}, RealTime{3 * step.end.ns - 5'000 * ms}};
  const StepCycle scaled = find_cycle(steps);
  REQUIRE(scaled.found);
  CHECK(scaled.boundaries == cycle.boundaries);
  CHECK(scaled.period.ns == 3 * cycle.period.ns);
  CHECK(scaled.regularity == cycle.regularity);
}

TEST_CASE("a pause stands out from the other gaps by a factor of 1.5, both measured with a quarter of a step besides") {
  for (const std::int64_t run_time : {200 * us, 1 * ms, 7 * ms}) {
    const auto found = [&](double factor, std::int64_t short_gap) {
      const auto quarter = static_cast<double>(run_time) / 4;
      const auto pause = static_cast<std::int64_t>(factor * (static_cast<double>(short_gap) + quarter) - quarter);
      std::vector<StepTimes> steps;
      RealTime now{};
      for (int n = 0; n < 15 * 40; ++n) {
        const RealTime begin = now + Duration{n % 15 == 0 ? pause : short_gap};
        now = begin + Duration{run_time};
        steps.push_back({begin, now});
      }
      const StepCycle cycle = find_cycle(steps);
      CHECK((!cycle.found || cycle.steps_per_segment == 15));
      return cycle.found;
    };
    for (const std::int64_t short_gap : {std::int64_t{0}, 30 * us, 3 * ms}) {
      INFO("steps of " << run_time << " ns, gaps of " << short_gap << " ns");
      CHECK(found(1.51, short_gap));
      CHECK(found(1.65, short_gap));
      CHECK_FALSE(found(1.49, short_gap));
    }
  }
}
