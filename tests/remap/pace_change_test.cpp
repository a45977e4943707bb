// A step change of V, N or the run time of steps, and what must not be taken for one.

#include <catch2/catch.hpp>

#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr double kStep_ns = 22'233'333.0 / 15;
struct Pace {
  double visualization_ns = 11'100'000;
  std::int32_t steps = 15;
  double step_ns = kStep_ns;
  double length_ns() const { return visualization_ns + steps * step_ns; }
};

/// `before` segments of one pace, then `after` of another, every instant the floor of the exact one.
Schedule changed(const Pace& from, const Pace& to, std::int64_t before, std::int64_t after) {
  Schedule schedule;
  double now_ns = 0;
  const auto floored = [](double ns) { return RealTime{static_cast<std::int64_t>(std::floor(ns))}; };
  for (std::int64_t k = 0; k < before + after; ++k) {
    const Pace& pace = k < before ? from : to;
    Segment segment{floored(now_ns), {}};
    const double first_ns = now_ns + pace.visualization_ns;
    for (std::int32_t i = 0; i < pace.steps; ++i) {
      segment.steps.push_back({floored(first_ns + i * pace.step_ns), floored(first_ns + (i + 1) * pace.step_ns), k, i});
    }
    now_ns += pace.length_ns();
    schedule.push_back(segment);
  }
  return schedule;
}

struct Outcome {
  double latency_ms;
  double jump;            // in slots of the shorter pace
  std::int64_t recovery;  // segments of the new pace until no velocity jump is above 1e-6 slot + 1 ns any more
  std::int64_t pace_changes;
  bool steps_back;
};
constexpr std::int64_t kChange = 60;

Outcome outcome(const Pace& to) {
  const Schedule schedule = changed({}, to, kChange, 150);
  PhaseLockedMap map({}, {});
  const std::vector<Placed> placed = place(map, schedule);
  const SamplingGrid grid{{1000, 1}, {}};
  const LatencyBudget budget = least_latency_any_phase(mapped_steps(placed), std::span(&grid, 1), Emission::hold);
  const double slot_ns = std::min(Pace{}.length_ns() / 15, to.length_ns() / to.steps);
  Outcome result{static_cast<double>(budget.latency.ns) * 1e-6, 0, 0, map.pace_changes(), false};
  for (std::size_t n = 15 * 40; n + 1 < placed.size(); ++n) {
    const Duration after = placed[n + 1].slot.read - placed[n].slot.read;
    const Duration before = placed[n].slot.read - placed[n - 1].slot.read;
    const double jump_ns = static_cast<double>(std::abs((after - before).ns));
    result.jump = std::max(result.jump, jump_ns / slot_ns);
    result.steps_back |= after.ns <= 0;
    if (jump_ns > 1 + 1e-6 * slot_ns) result.recovery = placed[n].real.segment - kChange + 1;
  }
  return result;
}

double period_after(const Schedule& schedule) {
  PhaseLockedMap map({}, {});
  place(map, schedule);
  return map.period_ns();
}

}  // namespace

TEST_CASE("a step of V, of N or of all run times: latency, jump and recovery as in the table of docs/numerics.md") {
  // Latency to the digits of the table; jump rounded up; recovery exactly.
  struct Row {
    const char* change;
    Pace to;
    double latency_ms;
    double jump;
    std::int64_t recovery;
  };
  const auto all = [](double factor) { return Pace{11'100'000 * factor, 15, kStep_ns * factor}; };
  const Row rows[]{{"V x 2", {22'200'000}, 35.042, 0.34, 11},
                   {"V x 1/2", {5'550'000}, 19.965, 0.17, 19},
                   {"V x 3", {33'300'000}, 57.242, 0.67, 7},
                   {"V gone", {0}, 24.682, 0.50, 26},
                   {"N 15 to 30", {11'100'000, 30}, 23.942, 0.30, 6},
                   {"N 15 to 8", {11'100'000, 8}, 18.022, 0.30, 24},
                   {"T x 0.5", all(0.5), 29.879, 1.01, 34},
                   {"T x 0.75", all(0.75), 21.361, 0.34, 21},
                   {"T x 1.25", all(1.25), 24.321, 0.26, 12},
                   {"T x 1.5", all(1.5), 35.800, 0.51, 9},
                   {"T x 2", all(2), 58.758, 1.26, 6},
                   {"T x 3", all(3), 129.673, 2.26, 7}};
  for (const Row& row : rows) {
    const Outcome result = outcome(row.to);
    INFO(row.change);
    CHECK(result.latency_ms == Approx(row.latency_ms).margin(0.0006));
    CHECK(result.jump <= row.jump);
    CHECK(result.recovery == row.recovery);
    CHECK(result.pace_changes == 1);
    CHECK_FALSE(result.steps_back);
  }
}

TEST_CASE("a longer V needs exactly V' + s + (T' - T) + c, the least of all continuous maps, from 1.7 V to 3 V") {
  // Below 1.6 V one segment is less than 20 % off and the linear loop alone bounds the latency.
  for (int percent = 170; percent <= 300; percent += 5) {
    const double visualization_ns = 111'000.0 * percent;
    const double least_ms = (visualization_ns + kStep_ns + (visualization_ns - 11'100'000) + 259'999) * 1e-6;
    REQUIRE(outcome({visualization_ns}).latency_ms == Approx(least_ms).margin(5e-6));
  }
}

TEST_CASE("one odd segment of more than 20 % is made good in the next; a lesser one is left to the loop") {
  for (int percent = -45; percent <= 45; ++percent) {
    if (std::abs(percent) == 20) continue;  // on the threshold: either, by a ns
    Schedule schedule = Periodic{}.schedule(40);
    const Duration odd{std::llround(percent / 100.0 * 1e9 / 30)};
    for (std::size_t k = 21; k < schedule.size(); ++k) schedule[k].begin = schedule[k].begin + odd;
    const std::vector<Placed> placed = place(PhaseLockedMap({}, {}), schedule);
    // Segment 20 is odd, 21 makes it good: the slot of the first step of segment 22 against its boundary.
    const auto error_ns = static_cast<double>((schedule[22].begin - placed[22 * 15].slot.read).ns);
    const double w = 2 * std::numbers::pi * 2 / 30;
    const double left = std::abs(percent) > 20 ? 0 : 1 - std::numbers::sqrt2 * w - w * w;
    INFO(percent << " %");
    REQUIRE(std::abs(error_ns - left * static_cast<double>(odd.ns)) <= 3);
  }
}

TEST_CASE("two equal segments of another pace make it P at once, one does not: 17 % to 80 %, up and down") {
  for (int percent = -45; percent <= 80; ++percent) {
    if (std::abs(percent) < 17) continue;
    const double factor = 1 + percent / 100.0;
    const Pace to{11'100'000 * factor, 15, kStep_ns * factor};
    const double slot_ns = to.length_ns() / 15;
    INFO(percent << " %");
    // The last segment of a schedule is not complete: + 1.
    REQUIRE(period_after(changed({}, to, 30, 3)) == Approx(slot_ns).epsilon(1e-7));
    REQUIRE(std::abs(period_after(changed({}, to, 30, 2)) / slot_ns - 1) > 0.02);
    REQUIRE(period_after(changed({}, to, 30, 60)) == Approx(slot_ns).epsilon(1e-7));
  }
}

TEST_CASE("two unlike segments, or two of opposite sign, are no new pace") {
  const auto with = [](double first, double second) {
    Schedule schedule = Periodic{}.schedule(33);  // segments 30 and 31 are the odd ones
    const Duration one{std::llround(first * 1e9 / 30)}, two{std::llround(second * 1e9 / 30)};
    for (std::size_t k = 31; k < schedule.size(); ++k) schedule[k].begin = schedule[k].begin + one;
    for (std::size_t k = 32; k < schedule.size(); ++k) schedule[k].begin = schedule[k].begin + two;
    PhaseLockedMap map({}, {});
    place(map, schedule);
    return map.pace_changes();
  };
  for (int percent = 17; percent <= 45; ++percent) {
    const double off = percent / 100.0;
    CHECK(with(off, off) == 1);
    CHECK(with(-off, -off) == 1);
    CHECK(with(off, off + 0.055) == 1);
    CHECK(with(off, off + 0.065) == 0);
    CHECK(with(off + 0.065, off) == 0);
    CHECK(with(off, -off) == 0);
    CHECK(with(off, 0) == 0);
  }
  for (int percent = 0; percent < 16; ++percent) CHECK(with(percent / 100.0, percent / 100.0) == 0);
}

TEST_CASE("a new pace is that of both segments together, weighted by their steps") {
  for (std::int32_t percent = 20; percent <= 24; ++percent) {
    for (std::int32_t steps = 10; steps <= 20; ++steps) {
      Schedule schedule = Periodic{}.schedule(31);  // 0 to 29 complete
      const double slot_ns = 1e9 / 450 * (1 + percent / 100.0);
      const RealTime begin = schedule[30].begin;
      const Duration first{std::llround(15 * 1e9 / 450 * 1.22)}, second{std::llround(steps * slot_ns)};
      schedule.push_back({begin + first, std::vector<StepTimes>(static_cast<std::size_t>(steps))});
      schedule.push_back({begin + first + second, {}});
      const double both_ns = static_cast<double>((first + second).ns) / (15 + steps);
      CHECK(period_after(schedule) == Approx(both_ns).epsilon(1e-12));
    }
  }
}

namespace {

Schedule steps_drawn(Draw& draw, std::int64_t count) {
  Schedule schedule;
  RealTime now{};
  for (std::int64_t k = 0; k < count; ++k) {
    Segment segment{now, {}};
    now = now + Duration{11'100'000};
    const auto steps = static_cast<std::int32_t>(draw.between(14, 16));
    for (std::int32_t i = 0; i < steps; ++i) {
      segment.steps.push_back({now, now + Duration{1'482'222}, k, i});
      now = now + Duration{1'482'222};
    }
    schedule.push_back(segment);
  }
  return schedule;
}
std::int64_t pace_changes(const Schedule& schedule) {
  PhaseLockedMap map({}, {});
  place(map, schedule);
  return map.pace_changes();
}

}  // namespace

TEST_CASE("10 % jitter, N drawn from 14 to 16 and a drift of 10 %/s are no new pace, 100,000 segments of each") {
  Draw draw(2024);
  CHECK(pace_changes(jittered(draw, 0.1, 100'000)) == 0);
  CHECK(pace_changes(steps_drawn(draw, 100'000)) == 0);
  // 10 %/s for 4 s, up and down, without jitter and with 10 %: 120 segments at a time. 0.1 * 33.3 ms / 30 = 0.111 ms.
  for (const double drift_ns : {-111'111.0, 111'111.0}) {
    for (const double variation : {0.0, 0.1}) {
      std::int64_t found = 0;
      for (int run = 0; run < 210; ++run) found += pace_changes(jittered(draw, variation, 120, drift_ns));
      CHECK(found == 0);
    }
  }
}

TEST_CASE("10 % jitter is no new pace in a million segments", "[million]") {
  std::int64_t found = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Draw draw(seed + 77);
    found += pace_changes(jittered(draw, 0.1, 100'000));
  }
  CHECK(found == 0);
}

TEST_CASE("under 10 % jitter a pace of 150 % is found within 6 segments, and the map stays continuous, 300 seeds") {
  std::int64_t found = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Draw draw(seed);
    Schedule schedule = jittered(draw, 0.1, 60);
    const RealTime turn = schedule[30].begin;
    const auto stretched = [&](RealTime t) { return t < turn ? t : turn + Duration{(t - turn).ns * 3 / 2}; };
    for (Segment& segment : schedule) {
      segment.begin = stretched(segment.begin);
      for (StepTimes& step : segment.steps) {
        step.begin = stretched(step.begin);
        step.end = stretched(step.end);
      }
    }
    schedule.resize(37);
    PhaseLockedMap map({}, {});
    std::int64_t n = 0;
    for (const Segment& segment : schedule) {
      PhaseLockedMap untold = map;
      map.boundary(n, segment.begin);
      PhaseLockedMap told = map;
      const Slot before = untold.read(n, {});
      if (before.kind == SlotKind::mapped) REQUIRE(std::abs((told.read(n, {}).read - before.read).ns) <= 1);
      for (std::size_t i = 0; i < segment.steps.size(); ++i, ++n) {
        map.read(n, {});
        map.emission(n, {});
      }
    }
    found += map.pace_changes() > 0;
    if (map.pace_changes() > 0) CHECK(map.period_ns() == Approx(1.5 * 1e9 / 450).epsilon(0.3));
  }
  CHECK(found >= 270);
}
