// The haptic loop does what a Remapper does: told of a run's ticks, segments and steps, a Remapper gives exactly the read
// times, emission times and forces of the run.

#include "evenstep/remap/remapper.h"

#include <algorithm>
#include <tuple>

#include "evenstep/harness/sizing.h"
#include "evenstep/harness/strategy_run.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

RemapperOptions options_of(const Scenario& scenario, const StrategyPlan& plan) {
  RemapperOptions options{.lead = plan.lead,
                          .latency = plan.latency,
                          .emission = scenario.devices[0].emission,
                          .bandwidth_Hz = scenario.remap.bandwidth_Hz,
                          .interaction_capacity = plan.interaction_capacity,
                          .force_capacity = plan.force_capacity};
  if (plan.adapts) options.adapt = scenario.remap.adapt;
  if (scenario.remap.interaction_underrun == InteractionUnderrun::extrapolate) options.past_newest_sample = kContinueLine;
  if (scenario.remap.force_underrun == ForceUnderrun::extrapolate) options.past_newest_force = kContinueLine;
  return options;
}

/// The events of a run in the order in which they happened: at one instant ends come first, then ticks, then beginnings.
enum class What { step_end, tick, segment, step_begin };
using Happened = std::tuple<RealTime, What, std::size_t>;
std::vector<Happened> events_of(const StrategyRecord& run) {
  std::vector<Happened> events;
  for (std::size_t i = 0; i < run.segments.size(); ++i) events.emplace_back(run.segments[i].begin, What::segment, i);
  for (std::size_t k = 0; k < run.devices[0].ticks.size(); ++k)
    events.emplace_back(run.devices[0].ticks[k].at, What::tick, k);
  for (std::size_t n = 0; n < run.steps.size(); ++n) {
    events.emplace_back(run.steps[n].begin, What::step_begin, n);
    events.emplace_back(run.steps[n].end, What::step_end, n);
  }
  std::sort(events.begin(), events.end());
  return events;
}

/// How many numbers differ between the run and the Remapper.
struct Differences {
  std::int64_t slots = 0, positions = 0, emissions = 0, forces = 0;
};
Differences replay(const StrategyRecord& run, Remapper<Vec3>& remap) {
  Differences differ;
  const DeviceRecord& device = run.devices[0];
  for (const auto& [at, what, i] : events_of(run)) {
    if (what == What::segment) remap.segment(at);
    if (what == What::tick) {
      remap.sample(at, device.ticks[i].position_m);
      differ.forces += remap.force(at).value != device.ticks[i].force_N;
    }
    if (what == What::step_begin) {
      const StepInput<Vec3> input = remap.begin_step(at);
      differ.slots += input.slot.read != run.steps[i].read || (input.slot.kind == SlotKind::mapped) != run.steps[i].mapped;
      differ.positions += input.hand.value != device.steps[i].position_m;
    }
    if (what == What::step_end) differ.emissions += remap.end_step(at, device.steps[i].force_N).at != run.steps[i].emission;
  }
  return differ;
}

std::uint64_t underruns(const StrategyRecord& run, UnderrunRow::Side side) {
  return static_cast<std::uint64_t>(
      std::count_if(run.underruns.begin(), run.underruns.end(), [&](const UnderrunRow& row) { return row.side == side; }));
}

}  // namespace

TEST_CASE("the haptic loop is the Remapper: every slot, position, emission time and force of a run, and its counts") {
  const auto [file, late] = GENERATE(table<const char*, bool>({{"paper/figure-1-spring.toml", false},
                                                               {"paper/figure-1-spring-hold.toml", false},
                                                               {"timing/jitter-10.toml", false},
                                                               {"timing/visualization-doubles-underruns.toml", true},
                                                               {"timing/extrapolate.toml", true},
                                                               {"timing/latency-adaptive-jitter.toml", true}}));
  CAPTURE(file);
  std::vector<std::string> set{"run.duration=\"4 s\"", "run.strategies=[\"phase_locked\"]", "expect=[]"};
  if (std::string(file).find("adaptive") != std::string::npos) set.push_back("remap.adapt.start=\"1 ms\"");  // it grows
  const Scenario scenario = read(file, set);
  REQUIRE(scenario.devices.size() == 1);
  const StrategyPlan phase_locked = plan(scenario).at(0);
  const StrategyRecord run = run_strategy(scenario, phase_locked, {});
  Remapper<Vec3> remap(options_of(scenario, phase_locked));
  const Differences differ = replay(run, remap);
  CHECK(run.steps.size() > 1000);
  CHECK(differ.slots == 0);
  CHECK(differ.positions == 0);
  CHECK(differ.emissions == 0);
  CHECK(differ.forces == 0);

  const RemapCounts counts = remap.counts();
  CHECK(counts.steps - counts.acquiring == static_cast<std::uint64_t>(std::count_if(
                                               run.steps.begin(), run.steps.end(), [](const auto& s) { return s.mapped; })));
  CHECK(counts.late_forces == underruns(run, UnderrunRow::Side::force));
  CHECK(counts.hand.held + counts.hand.extrapolated == underruns(run, UnderrunRow::Side::interaction));
  CHECK((counts.late_forces > 0) == late);
}
