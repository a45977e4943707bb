// What the budget and the oracles must keep on any timing: properties P5, P6, P8, P10 and P13, each on 100,000 random
// schedules, [million] on 1,000,000 others.

#include "../for_all.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/force_schedule.h"
#include "evenstep/remap/sample_buffer.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

std::vector<Placed> place_any(Draw& draw, const Schedule& schedule, Duration lead = {}, Duration latency = {}) {
  if (draw.between(0, 1) == 0) return place(PaperMap(lead, latency, 0.3), schedule);
  return place(PhaseLockedMap(lead, latency), schedule);
}
SamplingGrid any_grid(Draw& draw) {
  const Rate rates[]{{4000, 1}, {1000, 1}, {500, 1}, {10'000, 37}, {900, 1}};  // h = 0.25, 1, 2, 3.7 and 1.1 ms
  const Rate rate = rates[draw.between(0, 4)];
  return {rate, RealTime{draw.between(0, period_ceil(rate).ns - 1)}};
}

/// Are there reads that come before their sample at the worst phase of the device? At that phase the first sample at or
/// after R comes h - 1 ns after R.
bool reads_underrun(const std::vector<MappedStep>& steps, Rate rate, Duration lead) {
  const Duration latest = period_ceil(rate) - Duration{1};
  return std::any_of(steps.begin(), steps.end(), [&](const MappedStep& s) { return s.slot - lead + latest > s.begin; });
}
bool reads_underrun_here(const std::vector<MappedStep>& steps, SamplingGrid grid, Duration lead) {
  return std::any_of(steps.begin(), steps.end(), [&](const MappedStep& s) {
    return tick_time(grid.rate, first_tick_at_or_after(grid.rate, s.slot - lead, grid.origin), grid.origin) > s.begin;
  });
}
/// Are there forces whose step ends after they are due? They are due at F(n) or, if interpolated, at F(n - 1), with F as
/// SlotMap::emission repairs it.
bool forces_late(const std::vector<MappedStep>& steps, Duration lead, Duration latency, Emission emission) {
  std::optional<RealTime> before;
  for (const MappedStep& step : steps) {
    const RealTime wanted = step.slot - lead + latency;
    const RealTime emitted = before ? std::max(wanted, *before + Duration{1}) : wanted;
    if (step.end > (emission == Emission::linear && before ? *before : emitted)) return true;
    before = emitted;
  }
  return false;
}

const char* p5_tight(const Schedule& schedule, Draw draw) {
  const std::vector<MappedStep> steps = mapped_steps(place_any(draw, schedule));
  if (steps.empty()) return nullptr;
  const SamplingGrid grid = any_grid(draw);
  const Emission emission = draw.between(0, 1) == 0 ? Emission::hold : Emission::linear;
  constexpr Duration ns{1};
  const LatencyBudget any = least_latency_any_phase(steps, std::span(&grid, 1), emission);
  const LatencyBudget here = least_latency_this_phase(steps, std::span(&grid, 1), emission);
  if (reads_underrun(steps, grid.rate, any.lead)) return "any phase: a read underruns at c*";
  if (!reads_underrun(steps, grid.rate, any.lead - ns)) return "any phase: no read underruns at c* - 1 ns";
  if (reads_underrun_here(steps, grid, here.lead)) return "this phase: a read underruns at c*";
  if (!reads_underrun_here(steps, grid, here.lead - ns)) return "this phase: no read underruns at c* - 1 ns";
  for (const LatencyBudget& budget : {any, here}) {
    if (forces_late(steps, budget.lead, budget.latency, emission)) return "a force is late at L*";
    if (!forces_late(steps, budget.lead, budget.latency - ns, emission)) return "no force is late at L* - 1 ns";
  }
  return nullptr;
}

const char* p6_best_line(const Schedule& schedule, Draw draw) {
  std::vector<StepTimes> steps = flat(schedule);
  if (steps.size() < 2) return nullptr;
  const std::int64_t whole = best_line(steps).latency.ns;
  for (const StepTimes& step : steps)
    if (whole < (step.end - step.begin).ns) return "L* is below a run time";
  const auto last = static_cast<std::int64_t>(steps.size());
  const std::int64_t from = draw.between(0, last - 2);
  const std::int64_t count = draw.between(2, std::min<std::int64_t>(last - from, 8));
  const std::vector<StepTimes> part(steps.begin() + from, steps.begin() + from + count);
  const std::int64_t least = best_line(part).latency.ns;
  if (least > whole) return "L* of a part is above that of the whole";
  std::int64_t brute = INT64_MAX;
  for (std::size_t a = 0; a < part.size(); ++a) {
    for (std::size_t b = a + 1; b < part.size(); ++b) {
      const auto run = static_cast<std::int64_t>(b - a);
      brute = std::min(brute, bracket(part, (part[b].end - part[a].end).ns, run));
      brute = std::min(brute, bracket(part, (part[b].begin - part[a].begin).ns, run));
    }
  }
  return least == brute ? nullptr : "L* is not the least bracket of all slopes";
}

/// Only the map `paper` ever steps back.
bool steps_back(const std::vector<MappedStep>& steps) {
  for (std::size_t n = 1; n < steps.size(); ++n)
    if (steps[n].slot <= steps[n - 1].slot) return true;
  return false;
}

/// x = v t is sampled and read at R(n), f = k x is emitted at F(n) and played linearly. The result is k v (t - L), whichever
/// monotone map is used.
const char* p8_conjugate(const Schedule& schedule, Draw draw) {
  Draw same_map = draw;
  const std::vector<MappedStep> sized = mapped_steps(place_any(draw, schedule));
  const SamplingGrid grid = any_grid(draw);
  if (sized.size() < 2) return nullptr;
  if (steps_back(sized)) return nullptr;
  const LatencyBudget budget = least_latency_this_phase(sized, std::span(&grid, 1), Emission::linear);
  const std::vector<Placed> placed = place_any(same_map, schedule, budget.lead, budget.latency);
  // Positions count from the first slot. So they belong to times of some seconds, with a rounding of 1e-16.
  const RealTime zero = sized[0].slot;
  const double k_v = 1 + draw.unit();
  SampleBuffer<double> hand(budget.interaction_capacity);
  ForceSchedule<double> forces(placed.size() + 2, Emission::linear);
  std::int64_t tick = first_tick_at_or_after(grid.rate, zero - budget.lead, grid.origin) - 2;
  std::vector<RealTime> emissions;
  for (const Placed& step : placed) {
    if (step.slot.kind != SlotKind::mapped) continue;
    for (; tick_time(grid.rate, tick, grid.origin) <= step.real.begin; ++tick) {
      const RealTime at = tick_time(grid.rate, tick, grid.origin);
      hand.push(at, k_v * seconds(at - zero));
    }
    const Reading<double> force = hand.at(step.slot.read);
    if (force.status != ReadStatus::inside) return "a read underruns or overruns within the budget";
    const bool pushed_on = step.emission != step.slot.read + budget.latency;  // by acquiring steps that end late
    if (emissions.empty() && pushed_on) return nullptr;
    forces.push(step.emission, force.value);
    emissions.push_back(step.emission);
  }
  for (std::size_t n = 0; n + 1 < emissions.size(); ++n) {
    const RealTime at = emissions[n] + Duration{draw.between(0, (emissions[n + 1] - emissions[n]).ns)};
    const double line = k_v * seconds(at - budget.latency - zero);
    // Room for 4000 roundings of a second.
    if (std::abs(forces.at(at, n + 2).value - line) > 1e-12) return "the force is not k x(t - L)";
  }
  return nullptr;
}

/// Periodic timing needs s + Z (1 - 1/N) + h - 1 ns with the maps and, without the sampling term h - 1 ns, with the best
/// line.
const char* p10_periodic(Draw draw) {
  Periodic timing;
  timing.segments = {draw.between(10, 60), 1};
  timing.steps = static_cast<std::int32_t>(draw.between(1, 12));
  const std::int64_t segment_ns = period_ceil(timing.segments).ns;
  timing.visualization = {draw.between(0, segment_ns / 2)};
  timing.idle = {draw.between(0, 1) * draw.between(0, segment_ns / 4)};
  timing.steps_first = draw.between(0, 1) == 0;
  const SamplingGrid grid = any_grid(draw);
  const double rest_ns = static_cast<double>((timing.visualization + timing.idle).ns);
  const double step_ns = (1e9 / static_cast<double>(timing.segments.num) - rest_ns) / timing.steps;
  const double least_ns = step_ns + rest_ns * (1 - 1.0 / timing.steps);
  const double sampling_ns = static_cast<double>(period_ceil(grid.rate).ns - 1);
  const Schedule schedule = timing.schedule(5);
  // The floors of begins and ends make 1 ns each. Those of the slots make twice as much, and 2.2 ns more while the loop
  // follows a period that is 1 ns off.
  const auto straight = static_cast<double>(best_line(flat(schedule)).latency.ns);
  if (std::abs(straight - least_ns) > 3) return "the best line is off the formula";
  const std::vector<MappedStep> steps = mapped_steps(place_any(draw, schedule));
  const Duration latency = least_latency_any_phase(steps, std::span(&grid, 1), Emission::hold).latency;
  if (std::abs(static_cast<double>(latency.ns) - least_ns - sampling_ns) > 8) return "the map is off the formula";
  return nullptr;
}

/// At the latency that a map needs, its own path lies in the tube. The taut string lies there too and is more even.
const char* p13_taut(const Schedule& schedule, Draw draw) {
  const std::vector<MappedStep> mapped = mapped_steps(place_any(draw, schedule));
  if (mapped.size() < 3) return nullptr;
  const SamplingGrid grid = any_grid(draw);
  const Duration sampling = period_ceil(grid.rate) - Duration{1};
  const LatencyBudget budget = least_latency_any_phase(mapped, std::span(&grid, 1), Emission::hold);
  if (steps_back(mapped)) return nullptr;  // F is not R + L
  std::vector<StepTimes> steps;
  for (const MappedStep& step : mapped) steps.push_back({step.begin, step.end});
  const TautString string = taut_string(steps, budget.latency, sampling);
  if (string.infeasible_step) return "no path where a map has one";
  const double slot_ns = best_line(steps).slot_ns;
  double of_string = 0, of_map = 0, of_string_abs = 0, of_map_abs = 0, rounding = 0, rounding_abs = 0;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const RealTime low = steps[n].end - budget.latency, high = steps[n].begin - sampling;
    if (string.reads[n] < low || string.reads[n] > high) return "not in the tube";
    if (n == 0) continue;
    const double off = static_cast<double>((string.reads[n] - string.reads[n - 1]).ns) - slot_ns;
    const double map_off = static_cast<double>((mapped[n].slot - mapped[n - 1].slot).ns) - slot_ns;
    of_string += off * off;
    of_map += map_off * map_off;
    of_string_abs += std::abs(off);
    of_map_abs += std::abs(map_off);
    rounding += 2 * std::abs(off) + 1;  // each difference of floors is off by less than 1 ns
    rounding_abs += 1;
  }
  if (of_string > of_map + rounding) return "a map has less variance than the taut string";
  if (of_string_abs > of_map_abs + rounding_abs) return "a map has less variation than the taut string";
  return nullptr;
}

}  // namespace

TEST_CASE("P5 nothing underruns at c* and L*, something does 1 ns below: 100,000 schedules") { for_all(kMany, p5_tight); }
TEST_CASE("P6 L* is the least bracket, above each run time, and above that of each part, 100,000 schedules") {
  for_all(kMany, p6_best_line);
}
TEST_CASE("P8 without underrun a memoryless force is k x(t - L), whatever the map, 100,000 schedules") {
  for_all(kMany, p8_conjugate);
}
TEST_CASE("P10 periodic timing needs s + Z(1 - 1/N) + h - 1 ns: 100,000 timings") { for_all_draws(kMany, p10_periodic); }
TEST_CASE("P13 the taut string stays in the tube and is more even than any map: 100,000 schedules") {
  for_all(kMany, p13_taut);
}

TEST_CASE("P5 on a million schedules", "[million]") { for_all(kVeryMany, p5_tight); }
TEST_CASE("P6 on a million schedules", "[million]") { for_all(kVeryMany, p6_best_line); }
TEST_CASE("P8 on a million schedules", "[million]") { for_all(kVeryMany, p8_conjugate); }
TEST_CASE("P10 on a million timings", "[million]") { for_all_draws(kVeryMany, p10_periodic); }
TEST_CASE("P13 on a million schedules", "[million]") { for_all(kVeryMany, p13_taut); }
