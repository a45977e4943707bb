#include "strategies.h"

#include <algorithm>
#include <span>

#include "evenstep/remap/delay_locked_map.h"
#include "evenstep/remap/maps/clocked_map.h"
#include "evenstep/remap/paper_map.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/regression_map.h"
#include "evenstep/remap/source_maps.h"
#include "source_plan.h"
#include "src/parts/registered_map.h"

namespace evenstep {
namespace {

using internal::foreign_map;
using internal::Strategy;
using internal::underruns_of;

/// Ring capacity for a strategy that reads the newest sample and plays each force at once: it needs only the current entry
/// and the one before.
constexpr std::size_t kDirectCapacity = 4;

Duration chosen(const Budget& budget, Duration any_phase, Duration this_phase) {
  switch (budget.kind) {
    case Budget::Kind::any_phase:
      return any_phase;
    case Budget::Kind::this_phase:
      return this_phase;
    case Budget::Kind::fixed:
    case Budget::Kind::adaptive:  // the most it may become
      break;
  }
  return budget.fixed;
}

/// The longest span of read times that corresponds to a window of emission times: a shrinking latency moves forces closer
/// together.
Duration force_window(const RemapSpec& remap, const StrategyPlan& plan) {
  if (!plan.adapts) return kContinueLine.window;
  return {floor_mul_div(kContinueLine.window.ns + 1, 1'000'000, 1'000'000 - remap.adapt.slew_ppm) + 1};
}

/// Sets the capacities of the rings, which are never smaller than what reading the newest sample and playing forces at once
/// need.
void set_capacities(const LatencyBudget& rings, StrategyPlan& plan) {
  plan.interaction_capacity = std::max(rings.interaction_capacity, kDirectCapacity);
  plan.force_capacity = std::max(rings.force_capacity, kDirectCapacity);
}

/// A ring never holds more than the run puts into it, so a lead of an hour needs no room for an hour.
void limit_to_run(const Scenario& scenario, StrategyPlan& plan) {
  std::int64_t ticks = 0;
  for (const DeviceSpec& device : scenario.devices)
    ticks = std::max(ticks, first_tick_at_or_after(device.rate, RealTime{scenario.run_duration.ns}));
  // A device's clock is fast by a thousandth at most.
  const auto most = static_cast<std::size_t>(ticks + ticks / 1000) + kDirectCapacity;
  plan.interaction_capacity = std::min(plan.interaction_capacity, most);
}

/// The rings that the scenario gives, instead of those that the timing needs.
void give_rings(const Scenario& scenario, StrategyPlan& plan) {
  if (!scenario.remap.rings || !is_remap(plan.kind)) return;
  plan.needed = {plan.interaction_capacity, plan.force_capacity};
  plan.interaction_capacity = scenario.remap.rings->samples;
  plan.force_capacity = scenario.remap.rings->forces;
}

/// Predicts the counts of the judged part of the run, and sets the capacities, from one more walk.
void predict(const Scenario& scenario, const MapSetup& setup, Duration sample_window, Duration force_window,
             StrategyPlan& plan) {
  const RealTime judged_from{scenario.warmup.ns};
  RunningCapacities capacities(setup.grids, plan.lead, plan.latency, sample_window, force_window);
  std::vector<RunningUnderruns> devices = underruns_of(scenario, setup, plan);
  plan.predicted.resize(devices.size());
  each_run_step(scenario, plan, [&](std::span<const MappedStep> steps) {
    capacities.add(steps);
    for (std::size_t d = 0; d < devices.size(); ++d) {
      for (const MappedStep& step : steps) {
        const RunningUnderruns::Step found = devices[d].next(step);
        if (step.begin < judged_from) continue;
        plan.predicted[d].interaction_underruns += found.missing_by.ns > 0;
        plan.predicted[d].late_forces += found.late_by.ns > 0;
      }
    }
  });
  set_capacities(capacities.budget(), plan);
}

StrategyPlan plan_remap(const Scenario& scenario, StrategyKind kind) {
  StrategyPlan plan{kind};
  const MapSetup setup = map_setup(scenario);
  const RemapSpec& remap = scenario.remap;
  plan.sizing = size_map(setup, scenario.timing, kind);
  plan.lead = chosen(remap.lead, plan.sizing.any_phase.lead, plan.sizing.this_phase.lead);
  auto& [any, here] = plan.sizing;
  if (remap.interaction_underrun == InteractionUnderrun::gate) {
    plan.sizing = size_gated_map(setup, scenario.timing, kind, plan.lead);
  } else {
    // The least L is max(E - slot) + c, so another lead changes it by the same amount.
    for (LatencyBudget* least : {&any, &here}) least->latency += plan.lead - least->lead;
  }
  plan.latency = chosen(remap.latency, any.latency, here.latency);
  plan.adapts = remap.latency.kind == Budget::Kind::adaptive;
  const bool lines = remap.interaction_underrun == InteractionUnderrun::extrapolate;
  const bool force_lines = remap.force_underrun == ForceUnderrun::extrapolate;
  predict(scenario, setup, lines ? kContinueLine.window : Duration{}, force_lines ? force_window(remap, plan) : Duration{},
          plan);
  return plan;
}

/// Predicting needs no latency: each step gets the position that the hand will have when the step's force is due, and the
/// force is due as early as possible: R(n) = F(n) = slot(n) + D with D = max(E - slot), which is a lead of -D.
StrategyPlan plan_predict(const Scenario& scenario, StrategyKind kind) {
  StrategyPlan plan{kind};
  const MapSetup setup = map_setup(scenario);
  plan.sizing = size_map(setup, scenario.timing, kind);
  plan.lead = plan.sizing.any_phase.lead - plan.sizing.any_phase.latency;
  RunningCapacities capacities(setup.grids, plan.lead, plan.latency, scenario.remap.predict_window);
  each_run_step(scenario, plan, [&](std::span<const MappedStep> steps) { capacities.add(steps); });
  set_capacities(capacities.budget(), plan);
  return plan;
}

/// No lead and no latency. `ideal` has this plan if no strategy remaps; otherwise it becomes the twin of the one that does.
StrategyPlan plan_direct(const Scenario&, StrategyKind kind) {
  StrategyPlan plan{kind};
  set_capacities({}, plan);
  return plan;
}

std::unique_ptr<SlotMap> direct_map(const MapSetup&, Duration, const AdaptiveLatency&) {
  return std::make_unique<DirectMap>();
}

std::unique_ptr<SlotMap> paper_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<PaperMap>(lead, latency, setup.remap.estimate_weight, setup.remap.estimate_steps);
}

std::unique_ptr<SlotMap> phase_locked_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<PhaseLockedMap>(lead, latency, setup.remap.bandwidth_Hz, setup.remap.jump);
}

std::unique_ptr<SlotMap> delay_locked_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<DelayLockedMap>(lead, latency, setup.remap.bandwidth_Hz);
}

std::unique_ptr<SlotMap> regression_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<RegressionMap>(setup.step_rate, lead, latency, setup.remap.bandwidth_Hz);
}

std::unique_ptr<SlotMap> stamp_map(const MapSetup&, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<StampMap>(lead, latency);
}

std::unique_ptr<SlotMap> absolute_grid_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<AbsoluteGridMap>(setup.step_rate, lead, latency);
}

std::unique_ptr<SlotMap> clocked_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  Clocked clock{.step_rate = setup.step_rate};
  if (setup.remap.dropped_jump) {
    const double most_ns = *setup.remap.dropped_jump * static_cast<double>(instant_ns(setup.step_rate, 1));
    clock.most = {std::max<std::int64_t>(static_cast<std::int64_t>(most_ns), 1)};
  }
  return std::make_unique<ClockedMap>(clock, lead, latency);
}

std::unique_ptr<SlotMap> even_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency) {
  return std::make_unique<EvenMap>(RealTime{0}, setup.step_rate, lead, latency.latency());
}

void link_remap(const RemapSpec& remap, LinkSpec& link) {
  link.gate = remap.interaction_underrun == InteractionUnderrun::gate;
  if (remap.interaction_underrun == InteractionUnderrun::extrapolate) link.interaction = kContinueLine;
  if (remap.force_underrun == ForceUnderrun::extrapolate) link.force = kContinueLine;
}

void link_predict(const RemapSpec& remap, LinkSpec& link) {
  link.interaction = {remap.predict_window, kPredictHand.furthest};
}

void link_filtered(const RemapSpec& remap, LinkSpec& link) {
  if (remap.filter_force)
    link.force_filter = filter_at(remap, link.ticks.rate);
  else
    link.interaction_filter = filter_at(remap, link.step_rate);
}

void link_direct(const RemapSpec&, LinkSpec&) {}

// The colours are those of Okabe and Ito, which colour-blind people can tell apart. Curves that coincide must all be
// visible, so they are broad and pale below, thin and dark on top.
const Strategy kStrategies[] = {
    {StrategyKind::ideal, plan_direct, even_map, link_direct, {"#c4c4c4", 7, ""}},
    {StrategyKind::direct, plan_direct, direct_map, link_direct, {"#d55e00", 1.6, ""}},
    {StrategyKind::paper, plan_remap, paper_map, link_remap, {"#56b4e9", 3.4, "14 6"}},
    {StrategyKind::phase_locked, plan_remap, phase_locked_map, link_remap, {"#000000", 2, ""}},
    {StrategyKind::predict, plan_predict, phase_locked_map, link_predict, {"#cc79a7", 2, "12 4 2 4"}},
    {StrategyKind::filtered, plan_direct, direct_map, link_filtered, {"#e69f00", 2, "6 3"}},
    {StrategyKind::variable_step, plan_direct, direct_map, link_direct, {"#0072b2", 2, "1 3"}},
    {StrategyKind::foreign, plan_remap, foreign_map, link_remap, {"#009e73", 2, "9 4"}},
    {StrategyKind::jack_dll, plan_remap, delay_locked_map, link_remap, {"#009e73", 2, "12 3"}},
    {StrategyKind::lsl_dejitter, plan_remap, regression_map, link_remap, {"#cc79a7", 2, "7 3 2 3"}},
    {StrategyKind::linear, plan_remap, stamp_map, link_remap, {"#0072b2", 2, "10 3"}},
    {StrategyKind::absolute_grid, plan_remap, absolute_grid_map, link_remap, {"#cc79a7", 2, "2 2"}},
    {StrategyKind::holt_winters, plan_direct, direct_map, link_direct, {"#e69f00", 2, "8 2 2 2"}},
    {StrategyKind::polyphase, plan_remap, delay_locked_map, link_remap, {"#009e73", 2, "4 2"}},
    {StrategyKind::chunk_replace, plan_direct, direct_map, link_direct, {"#009e73", 2, ""}},
    {StrategyKind::chunk_append, plan_direct, direct_map, link_direct, {"#cc79a7", 2, "4 2"}},
    {StrategyKind::chunk_blend, plan_direct, direct_map, link_direct, {"#0072b2", 2, "8 3"}},
    {StrategyKind::clocked, plan_remap, clocked_map, link_remap, {"#009e73", 2, "6 2"}},
    {StrategyKind::interpolated, plan_direct, direct_map, link_direct, {"#e69f00", 2, "4 4"}},
};

}  // namespace

namespace internal {

const Strategy& strategy_of(StrategyKind kind) {
  return *std::find_if(std::begin(kStrategies), std::end(kStrategies),
                       [&](const Strategy& one) { return one.kind == kind; });
}

std::vector<RunningUnderruns> underruns_of(const Scenario& scenario, const MapSetup& setup, const StrategyPlan& plan) {
  std::vector<RunningUnderruns> devices;
  for (std::size_t d = 0; d < setup.grids.size(); ++d) {
    const Emission emission = scenario.devices[d].emission;
    devices.emplace_back(setup.grids[d], plan.lead, latency_of(setup, plan), emission,
                         needed_ahead(setup, plan.kind, emission));
  }
  return devices;
}

}  // namespace internal

std::vector<StrategyPlan> plan(const Scenario& scenario) {
  std::vector<StrategyPlan> plans;
  for (const StrategyKind kind : scenario.strategies) {
    plans.push_back(internal::strategy_of(kind).plan(scenario, kind));
    internal::add_room(scenario, plans.back());
    limit_to_run(scenario, plans.back());
    give_rings(scenario, plans.back());
  }
  const auto twin_of = [&](auto&& wanted) { return std::find_if(plans.begin(), plans.end(), wanted); };
  auto model = twin_of([&](const StrategyPlan& p) { return p.kind == scenario.live && is_remap(p.kind); });
  if (model == plans.end()) model = twin_of([](const StrategyPlan& p) { return is_remap(p.kind); });
  for (StrategyPlan& p : plans) {
    if (traits_of(p.kind).knows_motion && model != plans.end()) p = ideal_twin(scenario, *model);
  }
  return plans;
}

bool compares_with_twin(std::string_view metric) { return metric.starts_with("deviation_from_ideal"); }

StrategyPlan ideal_twin(const Scenario& scenario, const StrategyPlan& of) {
  StrategyPlan twin{StrategyKind::ideal, of.lead, of.latency};
  // The twin reads the motion in closed form, so its interaction ring is only written. Forces wait from the end of their
  // step until their emission, at most for L: one per slot, plus two to interpolate between.
  twin.interaction_capacity = kDirectCapacity;
  const Duration longest = std::min(of.latency - of.lead, scenario.run_duration);  // later ones are not emitted
  const std::int64_t waiting = floor_mul_div(std::max<std::int64_t>(longest.ns, 0), scenario.scene.step_rate.num,
                                             scenario.scene.step_rate.den * 1'000'000'000);
  twin.force_capacity = static_cast<std::size_t>(waiting) + kDirectCapacity;
  return twin;
}

}  // namespace evenstep
