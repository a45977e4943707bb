// Ring capacities, checked by a replay through the rings themselves.

#include <algorithm>

#include "../schedules.h"
#include "catch.h"
#include "evenstep/remap/sample_buffer.h"

using namespace evenstep;
using namespace evenstep::testing;

namespace {

constexpr Rate kRate{1000, 1};
constexpr SamplingGrid kGrid{kRate, {}};

/// The overruns among the reads of all steps from a ring of this capacity, if `arriving` samples come in after the head is
/// taken and before the read.
std::int64_t interaction_overruns(const std::vector<MappedStep>& steps, SamplingGrid grid, Duration lead,
                                  std::size_t capacity, int arriving) {
  SampleBuffer<double> ring(capacity);
  RealTime first = steps[0].begin;
  for (const MappedStep& step : steps) first = std::min(first, step.slot - lead);
  const std::int64_t origin = first_tick_at_or_after(grid.rate, first, grid.origin) - 2;
  std::int64_t overruns = 0;
  for (const MappedStep& step : steps) {
    const std::int64_t head = first_tick_at_or_after(grid.rate, step.begin + Duration{1}, grid.origin) - origin;
    while (static_cast<std::int64_t>(ring.head()) < head + arriving) {
      ring.push(tick_time(grid.rate, origin + static_cast<std::int64_t>(ring.head()), grid.origin), 0);
    }
    overruns += ring.at(step.slot - lead, static_cast<std::uint64_t>(head)).status == ReadStatus::overrun;
  }
  return overruns;
}

/// The overruns when the force schedule is played at every ns that matters: when a force arrives, when one is due, and 1 ns
/// before and after both.
std::int64_t force_overruns(const std::vector<Placed>& placed, Emission emission, std::size_t capacity, int arriving) {
  ForceSchedule<double> ring(capacity, emission);
  std::vector<RealTime> ticks;
  for (const Placed& step : placed) {
    for (std::int64_t off = -1; off <= 1; ++off) {
      ticks.push_back(step.emission + Duration{off});
      ticks.push_back(step.real.end + Duration{off});
    }
  }
  std::sort(ticks.begin(), ticks.end());
  std::size_t pushed = 0;
  std::int64_t overruns = 0;
  const auto push = [&] {
    if (pushed < placed.size()) ring.push(placed[pushed].emission, 0), ++pushed;
  };
  std::uint64_t head = 0;
  for (const RealTime tick : ticks) {
    for (; head < placed.size() && placed[head].real.end <= tick; ++head)
      if (pushed <= head) push();
    if (head == 0) continue;
    for (int i = 0; i < arriving; ++i)
      if (pushed < head + static_cast<std::uint64_t>(arriving)) push();
    overruns += ring.at(tick, head).status == ReadStatus::overrun;
  }
  return overruns;
}

struct Case {
  std::vector<MappedStep> sized;
  std::vector<Placed> placed;
  LatencyBudget budget;
};
Case make_case(std::uint64_t seed, SamplingGrid grid, Emission emission) {
  Draw draw(seed);
  const Schedule schedule = random_schedule(draw, 6);
  Case made;
  const bool paper = draw.between(0, 1) == 0;
  made.sized = mapped_steps(paper ? place(PaperMap({}, {}, 0.3), schedule) : place(PhaseLockedMap({}, {}), schedule));
  made.budget = least_latency_any_phase(made.sized, std::span(&grid, 1), emission);
  if (paper)
    made.placed = place(PaperMap(made.budget.lead, made.budget.latency, 0.3), schedule);
  else
    made.placed = place(PhaseLockedMap(made.budget.lead, made.budget.latency), schedule);
  std::erase_if(made.placed, [](const Placed& step) { return step.slot.kind != SlotKind::mapped; });
  return made;
}

}  // namespace

TEST_CASE("nothing overruns at the capacities given, 1000 traces, one entry less overruns") {
  std::int64_t interaction_tight = 0, force_tight = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    const SamplingGrid grid{kRate, RealTime{static_cast<std::int64_t>(seed) * 997}};
    const Emission emission = seed % 2 == 0 ? Emission::hold : Emission::linear;
    const Case made = make_case(seed, grid, emission);
    if (made.sized.size() < 2) continue;
    INFO("seed " << seed);
    const LatencyBudget& b = made.budget;
    REQUIRE(interaction_overruns(made.sized, grid, b.lead, b.interaction_capacity, 1) == 0);
    REQUIRE(force_overruns(made.placed, emission, b.force_capacity, 1) == 0);
    if (b.interaction_capacity > 2) {
      interaction_tight += interaction_overruns(made.sized, grid, b.lead, b.interaction_capacity - 1, 1) > 0;
    }
    if (b.force_capacity > 2) force_tight += force_overruns(made.placed, emission, b.force_capacity - 1, 1) > 0;
  }
  CHECK(interaction_tight > 100);
  CHECK(force_tight > 100);
}

TEST_CASE("a larger latency needs a larger force ring, and capacities_for gives it") {
  const Schedule schedule = Periodic{}.schedule(30);
  const SamplingGrid grid{kRate, {}};
  const auto sized = mapped_steps(place(PhaseLockedMap({}, {}), schedule));
  for (std::int64_t latency_ms = 13; latency_ms <= 60; ++latency_ms) {
    const Duration lead{260'000}, latency{latency_ms * 1'000'000};
    const LatencyBudget budget = capacities_for(sized, std::span(&grid, 1), lead, latency);
    CHECK(budget.lead == lead);
    CHECK(budget.latency == latency);
    std::vector<Placed> placed = place(PhaseLockedMap(lead, latency), schedule);
    std::erase_if(placed, [](const Placed& step) { return step.slot.kind != SlotKind::mapped; });
    CHECK(force_overruns(placed, Emission::hold, budget.force_capacity, 1) == 0);
    CHECK(force_overruns(placed, Emission::hold, budget.force_capacity - 1, 1) > 0);
  }
}

TEST_CASE("the windows of underrun policies find their base at the capacities given, and lose it at one less, 1000 traces") {
  // Each value is its own time. So a line that is continued gives the time asked for; if its base is lost, a value is held.
  std::int64_t samples_tight = 0, forces_tight = 0;
  for (std::uint64_t seed = 0; seed < 1000; ++seed) {
    Draw draw(seed + 5000);
    const Case made = make_case(seed, {kRate, {}}, Emission::linear);
    if (made.placed.size() < 2) continue;
    const Duration window{draw.between(1, 40'000'000)};
    const LatencyBudget budget =
        capacities_for(made.sized, std::span(&kGrid, 1), made.budget.lead, made.budget.latency, window, window);
    REQUIRE(budget.interaction_capacity >= made.budget.interaction_capacity);
    REQUIRE(budget.force_capacity >= made.budget.force_capacity);
    const auto lost_in = [&](auto&& ring, const std::vector<RealTime>& times) {
      std::int64_t lost = 0;
      for (std::size_t n = 0; n < times.size(); ++n) {
        ring.push(times[n], static_cast<double>((times[n] - times[0]).ns));
        if (n == 0 || times[n - 1] - window < times[0]) continue;  // the line had no base yet
        // One entry has arrived since the head was taken.
        const Reading<double> reading = ring.at(times[n - 1] + window, n);
        const double line = static_cast<double>((times[n - 1] + window - times[0]).ns);
        lost += std::abs(reading.value - line) > 1;
      }
      return lost;
    };
    std::vector<RealTime> ticks, emissions;
    for (std::int64_t k = 0; k < 100; ++k) ticks.push_back(tick_time(kRate, k));
    for (const Placed& step : made.placed) emissions.push_back(step.emission);
    const Extrapolation policy{window, {INT64_MAX}};
    INFO("seed " << seed);
    REQUIRE(lost_in(SampleBuffer<double>(budget.interaction_capacity, policy), ticks) == 0);
    REQUIRE(lost_in(ForceSchedule<double>(budget.force_capacity, Emission::linear, policy), emissions) == 0);
    const std::size_t fewer_samples = budget.interaction_capacity - 1, fewer_forces = budget.force_capacity - 1;
    samples_tight += fewer_samples >= 2 && lost_in(SampleBuffer<double>(fewer_samples, policy), ticks) > 0;
    forces_tight +=
        fewer_forces >= 2 && lost_in(ForceSchedule<double>(fewer_forces, Emission::linear, policy), emissions) > 0;
  }
  CHECK(samples_tight > 100);
  CHECK(forces_tight > 100);
}
