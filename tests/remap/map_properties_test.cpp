// What every map must keep on any timing. Counts are stated per test; [long] runs ten times as many.

#include <catch2/catch.hpp>

#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/sample_buffer.h"
#include "schedules.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr Duration kLead{700'000};
constexpr Duration kLatency{30'000'000};

std::vector<Placed> place_paper(const Schedule& s) { return place(PaperMap(kLead, kLatency, 0.1), s); }
std::vector<Placed> place_locked(const Schedule& s) { return place(PhaseLockedMap(kLead, kLatency), s); }

bool same(const Placed& a, const Placed& b) {
  return a.slot.read == b.slot.read && a.slot.kind == b.slot.kind && a.emission == b.emission;
}

/// Monotone, conserved, conjugate, deterministic.
void check_invariants(std::uint64_t seed) {
  Draw draw(seed);
  const Schedule schedule = random_schedule(draw, 12);
  std::size_t steps = 0;
  for (const Segment& segment : schedule) steps += segment.steps.size();

  PhaseLockedMap locked_map(kLead, kLatency);
  PaperMap paper_map(kLead, kLatency, 0.1);
  const std::vector<Placed> locked = place(locked_map, schedule);
  const std::vector<Placed> paper = place(paper_map, schedule);
  REQUIRE(locked.size() == steps);
  REQUIRE(paper.size() == steps);
  std::int64_t paper_repairs = 0;
  for (std::size_t n = 1; n < steps; ++n) {
    REQUIRE(locked[n].emission > locked[n - 1].emission);
    REQUIRE(paper[n].emission > paper[n - 1].emission);
    if (locked[n].slot.kind != SlotKind::mapped) continue;
    if (locked[n - 1].slot.kind == SlotKind::mapped) REQUIRE(locked[n].slot.read > locked[n - 1].slot.read);
    if (locked[n].emission != locked[n].slot.read + kLatency) {   // only after acquiring steps that end past it
      REQUIRE(locked[n].emission == locked[n - 1].emission + Duration{1});
      REQUIRE(locked_map.emission_repairs() > 0);
    }
    if (paper[n].emission != paper[n].slot.read + kLatency) {
      REQUIRE(paper[n].emission == paper[n - 1].emission + Duration{1});
      ++paper_repairs;
    }
  }
  REQUIRE(paper_map.emission_repairs() == paper_repairs);
  const std::vector<Placed> again = place_locked(schedule);
  REQUIRE(std::equal(locked.begin(), locked.end(), again.begin(), same));
}

/// Changing anything after the boundary of segment k changes no read or emission of a mapped step up to and in segment k.
void check_causality(std::uint64_t seed) {
  Draw draw(seed);
  const Schedule schedule = random_schedule(draw, 10);
  const auto from = static_cast<std::size_t>(draw.between(2, 9));
  Schedule changed = schedule;
  for (std::size_t k = from; k < changed.size(); ++k) {
    const Duration later{draw.between(1, 20'000'000)};
    if (k > from) changed[k].begin = std::max(changed[k].begin, changed[k - 1].begin) + later;
    for (StepTimes& step : changed[k].steps) { step.begin = step.begin + later; step.end = step.end + later; }
  }
  for (std::size_t k = from + 1; k < changed.size(); ++k) {
    changed[k].begin = std::max(changed[k].begin, changed[k - 1].begin);
  }
  std::size_t unchanged = 0;
  for (std::size_t k = 0; k <= from; ++k) unchanged += schedule[k].steps.size();
  const auto agree = [&](const std::vector<Placed>& a, const std::vector<Placed>& b) {
    for (std::size_t n = 0; n < unchanged; ++n) {
      if (a[n].slot.kind == SlotKind::mapped) REQUIRE(same(a[n], b[n]));
    }
  };
  agree(place_paper(schedule), place_paper(changed));
  agree(place_locked(schedule), place_locked(changed));
}

/// All times later by any whole number of ns: all reads and emissions later by as much, exactly. All times twice as long
/// at half the bandwidth: reads twice as far, to the ns of the two floors (and 1 ns where a sum rounds across one).
void check_equivariance(std::uint64_t seed) {
  Draw draw(seed);
  const Schedule schedule = random_schedule(draw, 10);
  const Duration shift{draw.between(-1'000'000'000'000'000, 1'000'000'000'000'000)};
  Schedule shifted = schedule, doubled = schedule;
  for (std::size_t k = 0; k < schedule.size(); ++k) {
    shifted[k].begin = schedule[k].begin + shift;
    doubled[k].begin = RealTime{2 * schedule[k].begin.ns};
    for (StepTimes& step : shifted[k].steps) step = {step.begin + shift, step.end + shift, step.segment, step.index};
    for (StepTimes& step : doubled[k].steps) step = {{2 * step.begin.ns}, {2 * step.end.ns}, step.segment, step.index};
  }
  const auto moved = [&](const std::vector<Placed>& a, const std::vector<Placed>& b) {
    for (std::size_t n = 0; n < a.size(); ++n) {
      REQUIRE(b[n].slot.read - a[n].slot.read == shift);
      REQUIRE(b[n].emission - a[n].emission == shift);
    }
  };
  moved(place_paper(schedule), place_paper(shifted));
  moved(place_locked(schedule), place_locked(shifted));
  const std::vector<Placed> once = place(PhaseLockedMap({}, {}, 2.0), schedule);
  const std::vector<Placed> twice = place(PhaseLockedMap({}, {}, 1.0), doubled);
  for (std::size_t n = 0; n < once.size(); ++n) {
    const std::int64_t off = twice[n].slot.read.ns - 2 * once[n].slot.read.ns;
    REQUIRE(off >= -1);
    REQUIRE(off <= 2);
  }
}

}  // namespace

TEST_CASE("maps are monotone, conserve steps, keep F - R and repeat bit for bit: 10,000 schedules") {
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) check_invariants(seed);
}
TEST_CASE("maps are monotone, conserve steps, keep F - R and repeat bit for bit: 100,000 schedules", "[long]") {
  for (std::uint64_t seed = 0; seed < 100'000; ++seed) check_invariants(seed + (1ULL << 32));
}
TEST_CASE("what happens later changes no slot: 10,000 schedules") {
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) check_causality(seed);
}
TEST_CASE("maps move with time and scale with it: 10,000 schedules") {
  for (std::uint64_t seed = 0; seed < 10'000; ++seed) check_equivariance(seed);
}

TEST_CASE("periodic timing is exact to 1e-6 step in deviation and velocity jump, at any phase") {
  // 1 ns of a slot of 1/450 s is 4.5e-7 step; two roundings of 1 ns are 9e-7 (docs/numerics.md).
  constexpr double slot_ns = 1e9 / 450;
  for (int phase = 0; phase < 200; ++phase) {
    const RealTime origin{phase * 166'667LL + phase};
    Schedule schedule = Periodic{}.schedule(120);
    for (Segment& segment : schedule) {
      segment.begin = segment.begin + (origin - RealTime{});
      for (StepTimes& step : segment.steps) { step.begin.ns += origin.ns; step.end.ns += origin.ns; }
    }
    for (const auto& placed : {place_paper(schedule), place_locked(schedule)}) {
      CHECK(velocity_jump(placed, 30, slot_ns) <= 1e-6);
      for (std::size_t n = 15; n < placed.size(); ++n) {
        const double line = static_cast<double>((origin - kLead).ns) + static_cast<double>(n) * slot_ns;
        REQUIRE(std::abs(static_cast<double>(placed[n].slot.read.ns) - line) / slot_ns <= 1e-6);
      }
    }
  }
}

TEST_CASE("10 % jitter: velocity jump of phase_locked at most 0.21 step, of paper at least 1: 100 seeds") {
  constexpr double slot_ns = 1e9 / 450;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Draw draw(seed);
    const Schedule schedule = jittered(draw, 0.1, 120);
    CHECK(velocity_jump(place_locked(schedule), 15 * 8, slot_ns) <= 0.21);
    CHECK(velocity_jump(place_paper(schedule), 15 * 8, slot_ns) >= 1.0);
  }
}

TEST_CASE("a memoryless spring shows no error of the map: its force is the line delayed by L, whatever the jitter") {
  // x = v t, sampled at 1 kHz, read at R(n), f = k x, emitted at F(n) = R(n) + L, played linearly: k v (t - L) at each tick.
  constexpr double v = 0.1, k = 200;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Draw draw(seed);
    const Schedule schedule = jittered(draw, 0.1, 60);
    const std::vector<MappedStep> sized = mapped_steps(place(PhaseLockedMap({}, {}), schedule));
    const SamplingGrid grid{{1000, 1}, {}};
    const LatencyBudget budget = least_latency_any_phase(sized, std::span(&grid, 1), Emission::linear);
    const std::vector<Placed> placed = place(PhaseLockedMap(budget.lead, budget.latency), schedule);
    REQUIRE(velocity_jump(placed, 30, 1e9 / 450) > 1e-3);   // the map itself is not even

    SampleBuffer<double> hand(10'000);
    ForceSchedule<double> forces(10'000, Emission::linear);
    std::int64_t tick = 0;
    RealTime first{INT64_MAX}, last{};
    for (const Placed& step : placed) {
      for (; tick_time(grid.rate, tick) <= step.real.begin; ++tick) {
        hand.push(tick_time(grid.rate, tick), v * seconds(tick_time(grid.rate, tick)));
      }
      if (step.slot.kind != SlotKind::mapped) continue;
      const Reading<double> x = hand.at(step.slot.read);
      REQUIRE(x.status == ReadStatus::inside);
      forces.push(step.emission, k * x.value);
      first = std::min(first, step.emission);
      last = step.emission;
    }
    for (std::int64_t t = first_tick_at_or_after(grid.rate, first); tick_time(grid.rate, t) <= last; ++t) {
      const RealTime at = tick_time(grid.rate, t);
      const double line_N = k * v * seconds(at - budget.latency);
      REQUIRE(std::abs(forces.at(at).value - line_N) <= 1e-12 * k);   // rounding of values up to 40 N
    }
  }
}
