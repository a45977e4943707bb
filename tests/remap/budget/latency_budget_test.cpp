#include "evenstep/remap/latency_budget.h"

#include "../schedules.h"
#include "catch.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

/// The reference case: 30 Hz, V = 11.1 ms, N = 15, device 1 kHz; 120 segments.
enum class Kind { paper, locked };
std::vector<MappedStep> mapped(Kind kind, const Periodic& timing = {}) {
  const Schedule schedule = timing.schedule(120);
  if (kind == Kind::paper) return mapped_steps(place(PaperMap({}, {}, 0.1), schedule));
  return mapped_steps(place(PhaseLockedMap({}, {}), schedule));
}
LatencyBudget any_phase(const std::vector<MappedStep>& steps, SamplingGrid grid, Emission emission = Emission::hold) {
  return least_latency_any_phase(steps, std::span(&grid, 1), emission);
}
LatencyBudget this_phase(const std::vector<MappedStep>& steps, SamplingGrid grid, Emission emission = Emission::hold) {
  return least_latency_this_phase(steps, std::span(&grid, 1), emission);
}

constexpr SamplingGrid k1kHz{{1000, 1}, {}};
/// 1 ns each because slots are floors, boundaries are floors, and phase_locked averages over boundaries.
constexpr std::int64_t kMapRounding_ns = 3;

}  // namespace

TEST_CASE("the reference case needs L = s + Z(1 - 1/N) + h - 1 ns at any phase: 12.842222 ms") {
  // s = 22.2333../15 ms = 1 482 222.2 ns, V (1 - 1/15) = 10 360 000 ns, h - 1 ns = 999 999 ns; c = h - 1 - V/N = 259 999 ns.
  for (const Kind kind : {Kind::paper, Kind::locked}) {
    const LatencyBudget budget = any_phase(mapped(kind), k1kHz);
    CHECK(std::abs(budget.lead.ns - 259'999) <= kMapRounding_ns);
    CHECK(std::abs(budget.latency.ns - 12'842'221) <= kMapRounding_ns);
  }
  // The integer maps give exactly these values:
  CHECK(any_phase(mapped(Kind::paper), k1kHz).lead.ns == 260'000);
  CHECK(any_phase(mapped(Kind::paper), k1kHz).latency.ns == 12'842'222);
}

TEST_CASE("at this phase the reference case needs 12.693333 ms at phase 0 and 12.527 ms at 0.5 ms, with c = 111111 ns") {
  const auto paper = mapped(Kind::paper), locked = mapped(Kind::locked);
  CHECK(this_phase(paper, k1kHz).lead.ns == 111'111);
  CHECK(this_phase(paper, k1kHz).latency.ns == 12'693'333);
  CHECK(std::abs(this_phase(locked, k1kHz).lead.ns - 111'111) <= 1);
  CHECK(std::abs(this_phase(locked, k1kHz).latency.ns - 12'693'333) <= kMapRounding_ns);
  const SamplingGrid half{{1000, 1}, RealTime{500'000}};
  for (const auto& steps : {paper, locked}) {
    CHECK(std::abs(this_phase(steps, half).latency.ns - 12'526'667) <= kMapRounding_ns);
  }
}

TEST_CASE("linear emission needs one slot more than hold: 15.064 ms in the reference case") {
  for (const Kind kind : {Kind::paper, Kind::locked}) {
    const auto steps = mapped(kind);
    CHECK(std::abs(any_phase(steps, k1kHz, Emission::linear).latency.ns - 15'064'443) <= kMapRounding_ns);
    const Duration more = any_phase(steps, k1kHz, Emission::linear).latency - any_phase(steps, k1kHz).latency;
    CHECK(std::abs(more.ns - 2'222'222) <= kMapRounding_ns);
    CHECK(any_phase(steps, k1kHz, Emission::linear).lead == any_phase(steps, k1kHz).lead);
  }
}

TEST_CASE("V + s underruns at phase 0 and not at 0.5 ms, however it is split between lead and emission") {
  const Duration v_plus_s{11'100'000 + 1'482'223};
  const SamplingGrid half{{1000, 1}, RealTime{500'000}};
  for (const Kind kind : {Kind::paper, Kind::locked}) {
    const auto steps = mapped(kind);
    for (std::int64_t lead = 0; lead <= 400'000; lead += 1'000) {
      CHECK(count_interaction_underruns(steps, k1kHz, {lead}) + count_late_forces(steps, {lead}, v_plus_s, Emission::hold) >
            0);
    }
    const LatencyBudget fits = this_phase(steps, half);
    CHECK(fits.latency < v_plus_s);
    CHECK(count_interaction_underruns(steps, half, fits.lead) == 0);
    CHECK(count_late_forces(steps, fits.lead, v_plus_s, Emission::hold) == 0);
  }
}

TEST_CASE("periodic timing needs L = s + Z(1 - 1/N) + h - 1 ns: 300 timings with and without idle time") {
  Draw draw(5);
  for (int trial = 0; trial < 300; ++trial) {
    Periodic timing;
    timing.segments = {draw.between(10, 60), 1};
    timing.steps = static_cast<std::int32_t>(draw.between(1, 40));
    const std::int64_t segment_ns = period_ceil(timing.segments).ns;
    timing.visualization = {draw.between(0, segment_ns / 2)};
    timing.idle = {draw.between(0, 1) * draw.between(0, segment_ns / 4)};
    const SamplingGrid grid{{draw.between(250, 4000), 1}, RealTime{draw.between(0, 999'999)}};
    const double rest_ns = static_cast<double>((timing.visualization + timing.idle).ns);
    const double step_ns = (1e9 / static_cast<double>(timing.segments.num) - rest_ns) / timing.steps;
    const double sampling_ns = static_cast<double>(period_ceil(grid.rate).ns - 1);
    const double least_ns = step_ns + rest_ns * (1 - 1.0 / timing.steps) + sampling_ns;
    for (const Kind kind : {Kind::paper, Kind::locked}) {
      const Duration latency = any_phase(mapped(kind, timing), grid).latency;
      CHECK(std::abs(static_cast<double>(latency.ns) - least_ns) <= kMapRounding_ns + 1);
    }
  }
}

TEST_CASE("steps-first needs a lead of V(1 - 1/N) + h - 1 ns, and the same latency") {
  Periodic timing;
  timing.steps_first = true;
  for (const Kind kind : {Kind::paper, Kind::locked}) {
    const LatencyBudget budget = any_phase(mapped(kind, timing), k1kHz);
    CHECK(std::abs(budget.lead.ns - (10'360'000 + 999'999)) <= kMapRounding_ns);
    CHECK(std::abs(budget.latency.ns - 12'842'221) <= kMapRounding_ns);
  }
}

TEST_CASE("the worst of all 250 000 phases of a 4 kHz device needs exactly the any-phase lead", "[sweep]") {
  Periodic timing;
  const auto all = mapped(Kind::paper, timing);
  const std::span<const MappedStep> steps(all.data(), 45);  // three segments: 100 ms, a whole number of device periods
  const Rate rate{4000, 1};
  const SamplingGrid any{rate, {}};
  const Duration lead = least_latency_any_phase(steps, std::span(&any, 1), Emission::hold).lead;
  std::int64_t phases_missed = 0;
  for (std::int64_t phase = 0; phase < 250'000; ++phase) {
    REQUIRE(count_interaction_underruns(steps, {rate, RealTime{phase}}, lead) == 0);
    phases_missed += count_interaction_underruns(steps, {rate, RealTime{phase}}, lead - Duration{1}) > 0;
  }
  // There is one such phase for each place on the device's grid where the last step of a segment can be.
  CHECK(phases_missed >= 1);
  CHECK(phases_missed <= 3);
}

TEST_CASE("the culprits are the steps that set lead and latency") {
  const auto at = [](std::int64_t step, std::int64_t begin, std::int64_t end, std::int64_t slot) {
    return MappedStep{step, RealTime{begin}, RealTime{end}, RealTime{slot}};
  };
  const std::vector<MappedStep> steps{at(7, 100, 110, 50), at(8, 110, 180, 100), at(9, 180, 190, 175),
                                      at(10, 200, 210, 190)};
  const SamplingGrid grid{{100'000'000, 1}, {}};  // h = 10 ns
  const LatencyBudget hold = any_phase(steps, grid);
  CHECK(hold.lead.ns == 175 + 9 - 180);
  CHECK(hold.lead_culprit == 9);
  CHECK(hold.latency.ns == 180 - 100 + 4);
  CHECK(hold.latency_culprit == 8);
  const LatencyBudget linear = any_phase(steps, grid, Emission::linear);
  CHECK(linear.latency.ns == 180 - 50 + 4);  // the interval after step 7 waits for step 8
  CHECK(linear.latency_culprit == 8);
}

TEST_CASE("a single step must be there itself, held or interpolated") {
  const MappedStep step{3, RealTime{100}, RealTime{140}, RealTime{90}};
  for (const Emission emission : {Emission::hold, Emission::linear}) {
    const LatencyBudget budget = least_latency_any_phase(std::span(&step, 1), {}, emission);
    CHECK(budget.latency.ns == 50);
    CHECK(budget.latency_culprit == 3);
  }
}

TEST_CASE("no steps and no devices need nothing") {
  const SamplingGrid grid = k1kHz;
  const LatencyBudget none = least_latency_any_phase({}, std::span(&grid, 1), Emission::linear);
  CHECK(none.lead.ns == 0);
  CHECK(none.latency.ns == 0);
  CHECK(none.interaction_capacity == 2);
  CHECK(none.force_capacity == 2);
  const auto steps = mapped(Kind::paper);
  CHECK(least_latency_this_phase(steps, {}, Emission::hold).lead.ns == 0);
}

TEST_CASE("of several devices the worst one counts") {
  const auto steps = mapped(Kind::locked);
  const std::vector<SamplingGrid> grids{{{4000, 1}, {}}, {{500, 1}, RealTime{123}}, {{1000, 1}, {}}};
  const LatencyBudget all = least_latency_any_phase(steps, grids, Emission::hold);
  const LatencyBudget all_here = least_latency_this_phase(steps, grids, Emission::hold);
  Duration worst{INT64_MIN}, worst_here{INT64_MIN};
  std::size_t samples = 0;
  for (const SamplingGrid& grid : grids) {
    worst = std::max(worst, any_phase(steps, grid).latency);
    worst_here = std::max(worst_here, this_phase(steps, grid).latency);
    samples = std::max(samples, capacities_for(steps, std::span(&grid, 1), all.lead, all.latency).interaction_capacity);
  }
  CHECK(all.latency == worst);
  CHECK(all_here.latency == worst_here);
  CHECK(all.interaction_capacity == samples);
}
