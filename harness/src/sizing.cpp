#include "evenstep/harness/sizing.h"

#include <algorithm>
#include <array>

#include "evenstep/loop/segment_pace.h"
#include "evenstep/remap/paper_map.h"
#include "evenstep/remap/phase_locked_map.h"

namespace evenstep {
namespace {

/// The steps of `ideal`: one per slot, each as long as a nominal step (but never longer than a slot).
class EvenTiming final : public StepTiming {
 public:
  EvenTiming(Rate step_rate, Duration run_time) : step_rate_(step_rate), run_time_(run_time) {}
  bool next(SegmentTiming& segment) override {
    const RealTime begin = tick_time(step_rate_, n_);
    const RealTime end = tick_time(step_rate_, n_ + 1);
    segment = {n_++, begin, std::nullopt, {{begin, std::min(begin + run_time_, end)}}, end};
    return true;
  }

 private:
  Rate step_rate_;
  Duration run_time_;
  std::int64_t n_ = 0;
};

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

/// Ring capacity for a strategy that reads the newest sample and plays each force at once: it needs only the current entry
/// and the one before.
constexpr std::size_t kDirectCapacity = 4;

/// How long a gate delays a step: not at all, or until the tick that brings the sample for slot - lead. At any phase this
/// tick comes at most a period minus 1 ns after that time.
struct GateModel {
  Duration lead;
  bool any_phase = false;

  RealTime opens(RealTime slot, const SamplingGrid& device) const {
    const RealTime read = slot - lead;
    if (any_phase) return read + period_ceil(device.rate) - Duration{1};
    return tick_time(device.rate, first_tick_at_or_after(device.rate, read, device.origin), device.origin);
  }
};

/// The haptic loop without its lanes and without a gate: visits every mapped step that ends within the run, with lead 0.
/// `next` returns the segments one by one, and a null pointer at the end.
template <class Next, class Visit>
void walk(const Scenario& scenario, StrategyKind kind, Next next, Visit visit) {
  const std::unique_ptr<SlotMap> map = make_map(scenario, kind, {}, Duration{});
  const RealTime end{scenario.run_duration.ns};
  std::int64_t n = 0;
  std::vector<RealTime> slots;
  for (const SegmentTiming* segment = next(); segment != nullptr && segment->begin < end; segment = next()) {
    map->boundary(n, segment->begin);
    slots.resize(segment->steps.size());
    const bool mapped = map->slots(n, slots);
    for (std::size_t i = 0; mapped && i < slots.size(); ++i) {
      const auto& [began, ended] = segment->steps[i];
      if (ended < end) visit({n + static_cast<std::int64_t>(i), began, ended, slots[i], segment->index});
    }
    n += std::ssize(slots);
  }
}

/// The same with a gate, which pushes back everything after a wait.
void walk_gated(const Scenario& scenario, StepTiming& timing, StrategyKind kind, const GateModel& gate,
                std::vector<MappedStep>& steps) {
  const std::unique_ptr<SlotMap> map = make_map(scenario, kind, {}, Duration{});
  const std::vector<SamplingGrid> grids = sampling_grids(scenario);
  const RealTime end{scenario.run_duration.ns};
  Postponement pushed;
  SegmentTiming segment;
  for (std::int64_t n = 0; timing.next(segment) && pushed.begin(segment.begin) < end;) {
    map->boundary(n, segment.begin);
    const Pause pause = pause_of(segment, segment.overlaps());
    if (pause.before_steps) pushed.end(segment.visualization->end);
    for (const Interval& step : segment.steps) {
      RealTime began = pushed.begin(step.begin);
      const Slot slot = map->read(n, began);
      if (slot.kind == SlotKind::mapped) {
        const RealTime launched = began;
        for (const SamplingGrid& grid : grids) began = std::max(began, gate.opens(slot.read, grid));
        pushed.wait(began - launched);
      }
      const RealTime ended = pushed.end(step.end);
      if (slot.kind == SlotKind::mapped && ended < end) steps.push_back({n, began, ended, slot.read, segment.index});
      map->emission(n, ended);
      ++n;
    }
    if (pause.after_steps) pushed.end(segment.visualization->end);
  }
}

std::vector<MappedStep> walk(const Scenario& scenario, StrategyKind kind, const GateModel* gate) {
  std::vector<MappedStep> steps;
  const std::unique_ptr<StepTiming> timing = make_timing(scenario);
  if (gate) {
    walk_gated(scenario, *timing, kind, *gate, steps);
  } else {
    SegmentTiming segment;
    walk(scenario, kind, [&] { return timing->next(segment) ? &segment : nullptr; },
         [&](const MappedStep& step) { steps.push_back(step); });
  }
  return steps;
}

/// The longest span of read times that corresponds to a window of emission times: a shrinking latency moves forces closer
/// together.
Duration force_window(const Scenario& scenario, const StrategyPlan& plan) {
  if (!plan.adapts) return kContinueLine.window;
  return {floor_mul_div(kContinueLine.window.ns + 1, 1'000'000, 1'000'000 - scenario.remap.adapt.slew_ppm) + 1};
}

StrategyPlan plan_remap(const Scenario& scenario, StrategyKind kind) {
  StrategyPlan plan{kind};
  plan.sizing = size_map(scenario, kind);
  plan.lead = chosen(scenario.remap.lead, plan.sizing.any_phase.lead, plan.sizing.this_phase.lead);
  const bool gated = scenario.remap.interaction_underrun == InteractionUnderrun::gate;
  if (gated) plan.sizing = size_gated_map(scenario, kind, plan.lead);
  const auto& [steps, any, here] = plan.sizing;
  // The least L is max(E - slot) + c, so another lead changes it by the same amount. That of a gate is for its lead already.
  const auto with_lead = [&](const LatencyBudget& least) {
    return gated ? least.latency : least.latency - least.lead + plan.lead;
  };
  plan.latency = chosen(scenario.remap.latency, with_lead(any), with_lead(here));
  plan.adapts = scenario.remap.latency.kind == Budget::Kind::adaptive;
  const std::vector<SamplingGrid> grids = sampling_grids(scenario);
  const bool lines = scenario.remap.interaction_underrun == InteractionUnderrun::extrapolate;
  const bool force_lines = scenario.remap.force_underrun == ForceUnderrun::extrapolate;
  const LatencyBudget rings = capacities_for(steps, grids, plan.lead, plan.latency, lines ? kContinueLine.window : Duration{},
                                             force_lines ? force_window(scenario, plan) : Duration{});
  plan.interaction_capacity = std::max(rings.interaction_capacity, kDirectCapacity);
  plan.force_capacity = std::max(rings.force_capacity, kDirectCapacity);

  const RealTime judged_from{scenario.warmup.ns};
  const auto first = std::find_if(steps.begin(), steps.end(), [&](const MappedStep& s) { return s.begin >= judged_from; });
  const std::span<const MappedStep> judged(first, steps.end());
  for (const SamplingGrid& grid : grids) {
    plan.predicted_interaction_underruns =
        std::max(plan.predicted_interaction_underruns, count_interaction_underruns(judged, grid, plan.lead));
  }
  const std::vector<bool> late = late_forces(steps, plan.lead, latency_of(scenario, plan));
  plan.predicted_late_forces = std::count(late.begin() + (first - steps.begin()), late.end(), true);
  return plan;
}

/// Predicting needs no latency: each step gets the position that the hand will have when the step's force is due, and the
/// force is due as early as possible: R(n) = F(n) = slot(n) + D with D = max(E - slot), which is a lead of -D.
StrategyPlan plan_predict(const Scenario& scenario) {
  StrategyPlan plan{StrategyKind::predict};
  plan.sizing = size_map(scenario, plan.kind);
  const auto& [steps, any, here] = plan.sizing;
  plan.lead = any.lead - any.latency;
  const std::vector<SamplingGrid> grids = sampling_grids(scenario);
  const LatencyBudget rings = capacities_for(steps, grids, plan.lead, plan.latency, scenario.remap.predict_window);
  plan.interaction_capacity = std::max(rings.interaction_capacity, kDirectCapacity);
  plan.force_capacity = std::max(rings.force_capacity, kDirectCapacity);
  return plan;
}

}  // namespace

std::unique_ptr<StepTiming> make_timing(const Scenario& scenario) {
  if (!scenario.timing.trace.empty()) return make_replayed_timing(scenario.timing.trace);
  return make_programmed_timing(scenario.timing.programmed);
}

std::unique_ptr<StepTiming> make_even_timing(const Scenario& scenario) {
  return std::make_unique<EvenTiming>(scenario.scene.step_rate, scenario.nominal.step_run_time);
}

std::unique_ptr<SlotMap> make_map(const Scenario& scenario, StrategyKind kind, Duration lead,
                                  const AdaptiveLatency& latency) {
  switch (kind) {
    case StrategyKind::direct:
    case StrategyKind::filtered:
    case StrategyKind::variable_step:
      return std::make_unique<DirectMap>();
    case StrategyKind::paper:
      return std::make_unique<PaperMap>(lead, latency, scenario.remap.estimate_weight);
    case StrategyKind::phase_locked:
    case StrategyKind::predict:
      return std::make_unique<PhaseLockedMap>(lead, latency, scenario.remap.bandwidth_Hz);
    case StrategyKind::ideal:
      return std::make_unique<EvenMap>(RealTime{0}, scenario.scene.step_rate, lead, latency.latency());
  }
  return nullptr;
}

std::vector<SamplingGrid> sampling_grids(const Scenario& scenario) {
  std::vector<SamplingGrid> grids;
  for (const DeviceSpec& device : scenario.devices) grids.push_back({device.rate, RealTime{device.phase.ns}});
  return grids;
}

Emission strictest_emission(const Scenario& scenario) {
  const bool linear = std::any_of(scenario.devices.begin(), scenario.devices.end(),
                                  [](const DeviceSpec& device) { return device.emission == Emission::linear; });
  return linear ? Emission::linear : Emission::hold;
}

Sizing size_map(const Scenario& scenario, StrategyKind kind) {
  Sizing sizing;
  sizing.steps = walk(scenario, kind, nullptr);
  const std::vector<SamplingGrid> grids = sampling_grids(scenario);
  sizing.any_phase = least_latency_any_phase(sizing.steps, grids, strictest_emission(scenario));
  sizing.this_phase = least_latency_this_phase(sizing.steps, grids, strictest_emission(scenario));
  return sizing;
}

std::vector<MappedStep> run_steps(const Scenario& scenario, StrategyKind kind, Duration lead) {
  const GateModel here{lead, false};
  return walk(scenario, kind, scenario.remap.interaction_underrun == InteractionUnderrun::gate ? &here : nullptr);
}

void each_mapped_step(const Scenario& scenario, StrategyKind kind, std::span<const SegmentTiming> segments,
                      const std::function<void(std::span<const MappedStep>)>& visit) {
  constexpr std::size_t kAtATime = 256;   // so few that they stay in the first-level cache
  std::array<MappedStep, kAtATime> steps;
  std::size_t next = 0, count = 0;
  walk(scenario, kind, [&] { return next < segments.size() ? &segments[next++] : nullptr; },
       [&](const MappedStep& step) {
         steps[count++] = step;
         if (count < kAtATime) return;
         visit(steps);
         count = 0;
       });
  visit(std::span(steps).first(count));
}

Sizing size_gated_map(const Scenario& scenario, StrategyKind kind, Duration lead) {
  Sizing sizing = size_map(scenario, kind);
  const std::vector<SamplingGrid> grids = sampling_grids(scenario);
  const auto with_lead = [&](LatencyBudget& budget, LatencyBudget gated) {
    budget.latency = gated.latency - gated.lead + lead;
    budget.latency_culprit = gated.latency_culprit;
  };
  const GateModel worst{lead, true}, here{lead, false};
  with_lead(sizing.any_phase,
            least_latency_any_phase(walk(scenario, kind, &worst), grids, strictest_emission(scenario)));
  sizing.steps = walk(scenario, kind, &here);
  with_lead(sizing.this_phase, least_latency_this_phase(sizing.steps, grids, strictest_emission(scenario)));
  return sizing;
}

AdaptiveLatency latency_of(const Scenario& scenario, const StrategyPlan& plan) {
  if (!plan.adapts) return plan.latency;
  AdaptiveLatencyOptions options = scenario.remap.adapt;
  options.emission = strictest_emission(scenario);
  return AdaptiveLatency(options);
}

AdaptationForecast forecast_adaptation(const Scenario& scenario, const StrategyPlan& plan) {
  AdaptationForecast forecast;
  AdaptiveLatency latency = latency_of(scenario, plan);
  std::int64_t sum_ns = 0, judged = 0;
  for (const MappedStep& step : plan.sizing.steps) {
    const RealTime read = step.slot - plan.lead;
    const Duration scheduled = latency.emission(read, step.end) - read;
    if (step.begin < RealTime{scenario.warmup.ns}) continue;
    ++judged;
    sum_ns += scheduled.ns;
    forecast.largest = std::max(forecast.largest, scheduled);
  }
  forecast.growths = latency.growths();
  if (judged > 0) forecast.mean_s = static_cast<double>(sum_ns) / static_cast<double>(judged) / 1e9;
  return forecast;
}

std::vector<StrategyPlan> plan(const Scenario& scenario) {
  std::vector<StrategyPlan> plans;
  for (const StrategyKind kind : scenario.strategies) {
    if (kind == StrategyKind::predict)
      plans.push_back(plan_predict(scenario));
    else if (is_remap(kind))
      plans.push_back(plan_remap(scenario, kind));
    else
      plans.push_back({kind, {}, {}, false, kDirectCapacity, kDirectCapacity});
  }
  const auto twin_of = [&](auto&& wanted) { return std::find_if(plans.begin(), plans.end(), wanted); };
  auto model = twin_of([&](const StrategyPlan& p) { return p.kind == scenario.live && is_remap(p.kind); });
  if (model == plans.end()) model = twin_of([](const StrategyPlan& p) { return is_remap(p.kind); });
  for (StrategyPlan& p : plans) {
    if (p.kind == StrategyKind::ideal && model != plans.end()) p = ideal_twin(scenario, *model);
  }
  return plans;
}

StrategyPlan ideal_twin(const Scenario& scenario, const StrategyPlan& of) {
  StrategyPlan twin{StrategyKind::ideal, of.lead, of.latency};
  // The twin reads the motion in closed form, so its interaction ring is only written. Forces wait from the end of their
  // step until their emission, at most for L: one per slot, plus two to interpolate between.
  twin.interaction_capacity = kDirectCapacity;
  const Duration longest = of.latency - of.lead;
  const std::int64_t waiting = floor_mul_div(std::max<std::int64_t>(longest.ns, 0), scenario.scene.step_rate.num,
                                             scenario.scene.step_rate.den * 1'000'000'000);
  twin.force_capacity = static_cast<std::size_t>(waiting) + kDirectCapacity;
  return twin;
}

}  // namespace evenstep
