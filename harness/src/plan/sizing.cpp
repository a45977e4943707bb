#include "evenstep/harness/sizing.h"

#include <algorithm>
#include <array>

#include "evenstep/loop/segment_pace.h"
#include "strategies.h"

namespace evenstep {
namespace {

constexpr std::int64_t kMostReserved = 2'000'000;  // steps; an hour at 450 Hz has 1.6 million
constexpr RealTime kHour{3'600'000'000'000};

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

/// How long a gate delays a step: not at all, or until the tick that brings the sample for slot - lead; a step without a
/// slot, until the first sample is there: that of the device's first tick, when it has its age. At any phase a tick comes at
/// most a period minus 1 ns after the time for which it is needed, and the first one after t = 0.
struct GateModel {
  Duration lead;
  bool any_phase = false;

  RealTime opens(const Slot& slot, const SamplingGrid& device) const {
    const Duration period = period_ceil(device.rate);
    const auto tick_at_or_after = [&](RealTime at) {
      if (any_phase) return at + period - Duration{1};
      return tick_time(device.rate, first_tick_at_or_after(device.rate, at, device.origin), device.origin);
    };
    // The first sample is that of a tick, so no phase makes it wait for more than whole periods.
    const RealTime first =
        any_phase ? tick_at_or_after(RealTime{} + period * first_tick_at_or_after(device.rate, RealTime{device.age.ns}))
                  : tick_at_or_after(device.origin + device.age);
    if (slot.kind != SlotKind::mapped) return first;
    return std::max(first, tick_at_or_after(slot.read - lead + device.age));
  }
};

/// The haptic loop without its lanes and without a gate: visits every mapped step that ends before `end`. `next` returns
/// the segments one by one, and a null pointer at the end.
template <class Next, class Visit>
void walk(SlotMap& map, RealTime end, Next next, Visit visit) {
  std::int64_t n = 0;
  for (const SegmentTiming* segment = next(); segment != nullptr && segment->begin < end; segment = next()) {
    map.boundary(n, segment->begin);
    for (const Interval& step : segment->steps) {
      const Transport way = segment->transport(step);
      const Slot slot = map.read(n, step.begin);
      map.emission(n, step.end + way.delay);
      if (slot.kind == SlotKind::mapped && step.end < end)
        visit({n, step.begin, step.end + way.delay, slot.read, segment->index, way.lost});
      ++n;
    }
  }
}

/// The same with a gate, which pushes back everything after a wait.
void walk_gated(const MapSetup& setup, StepTiming& timing, StrategyKind kind, const GateModel& gate,
                std::vector<MappedStep>& steps) {
  const std::unique_ptr<SlotMap> map = make_map(setup, kind, {}, Duration{});
  const RealTime end = setup.end;
  Postponement pushed;
  SegmentTiming segment;
  for (std::int64_t n = 0; timing.next(segment) && pushed.begin(segment.begin) < end;) {
    map->boundary(n, segment.begin);
    const Pause pause = pause_of(segment, segment.overlaps());
    if (pause.before_steps) pushed.end(segment.visualization->end);
    for (const Interval& step : segment.steps) {
      RealTime began = pushed.begin(step.begin);
      const Slot slot = map->read(n, began, pushed.by());
      const RealTime launched = began;
      for (const SamplingGrid& grid : setup.grids) began = std::max(began, gate.opens(slot, grid));
      pushed.wait(began - launched);
      const RealTime ended = pushed.end(step.end);
      const Transport way = segment.transport(step);
      if (slot.kind == SlotKind::mapped && ended < end)
        steps.push_back({n, began, ended + way.delay, slot.read, segment.index, way.lost});
      map->emission(n, ended + way.delay, pushed.by());
      ++n;
    }
    if (pause.after_steps) pushed.end(segment.visualization->end);
  }
}

std::vector<MappedStep> walk(const MapSetup& setup, const TimingSpec& timing_spec, StrategyKind kind,
                             const GateModel* gate) {
  std::vector<MappedStep> steps;
  const std::int64_t expected =
      floor_mul_div(std::min(setup.end, kHour).ns, setup.step_rate.num, setup.step_rate.den * 1'000'000'000);
  steps.reserve(static_cast<std::size_t>(std::clamp<std::int64_t>(expected, 0, kMostReserved)));  // growing would copy
  const std::unique_ptr<StepTiming> timing = make_timing(timing_spec);
  if (gate) {
    walk_gated(setup, *timing, kind, *gate, steps);
  } else {
    SegmentTiming segment;
    walk(
        *make_map(setup, kind, {}, Duration{}), setup.end, [&] { return timing->next(segment) ? &segment : nullptr; },
        [&](const MappedStep& step) { steps.push_back(step); });
  }
  return steps;
}

}  // namespace

std::unique_ptr<StepTiming> make_timing(const TimingSpec& timing) {
  const bool recorded = !timing.trace.empty();
  std::unique_ptr<StepTiming> steps =
      recorded ? make_replayed_timing(timing.trace) : make_programmed_timing(timing.programmed);
  if (timing.governor)
    steps = make_governed_timing(std::move(steps), *timing.governor,
                                 recorded ? grid_period(timing.trace) : grid_period(timing.programmed));
  if (!timing.elsewhere) return steps;
  SourceSpec source = *timing.elsewhere;
  source.seed = timing.programmed.seed;  // further seeds of a run are set there
  return make_source_timing(std::move(steps), source);
}

std::unique_ptr<StepTiming> make_even_timing(Rate step_rate, Duration run_time) {
  return std::make_unique<EvenTiming>(step_rate, run_time);
}

std::vector<SamplingGrid> sampling_grids(const Scenario& scenario) {
  std::vector<SamplingGrid> grids;
  for (const DeviceSpec& device : scenario.devices)
    grids.push_back({device.rate, RealTime{device.phase.ns}, largest_age(device)});
  return grids;
}

MapSetup map_setup(const Scenario& scenario) {
  const bool linear = std::any_of(scenario.devices.begin(), scenario.devices.end(),
                                  [](const DeviceSpec& device) { return device.emission == Emission::linear; });
  return {.remap = scenario.remap,
          .step_rate = scenario.scene.step_rate,
          .grids = sampling_grids(scenario),
          .emission = linear ? Emission::linear : Emission::hold,
          .end = RealTime{scenario.run_duration.ns},
          .source_period = scenario.playing.resampler.period,
          .taps = scenario.playing.resampler.taps};
}

std::unique_ptr<SlotMap> make_map(const MapSetup& setup, StrategyKind kind, Duration lead, const AdaptiveLatency& latency) {
  return internal::strategy_of(kind).map(setup, lead, latency);
}

Sizing size_map(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind) {
  Sizing sizing;
  sizing.steps = walk(setup, timing, kind, nullptr);
  sizing.any_phase = least_latency_any_phase(sizing.steps, setup.grids, setup.emission);
  sizing.this_phase = least_latency_this_phase(sizing.steps, setup.grids, setup.emission);
  const Duration ahead = needed_ahead(setup, kind, setup.emission);
  for (LatencyBudget* least : {&sizing.any_phase, &sizing.this_phase}) least->latency = least->latency + ahead;
  return sizing;
}

std::vector<MappedStep> run_steps(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, Duration lead) {
  const GateModel here{lead, false};
  return walk(setup, timing, kind, setup.remap.interaction_underrun == InteractionUnderrun::gate ? &here : nullptr);
}

void each_mapped_step(const MapSetup& setup, StrategyKind kind, std::span<const SegmentTiming> segments,
                      const std::function<void(std::span<const MappedStep>)>& visit) {
  each_mapped_step(*make_map(setup, kind, {}, Duration{}), setup.end, segments, visit);
}

void each_mapped_step(SlotMap& map, RealTime end, std::span<const SegmentTiming> segments,
                      const std::function<void(std::span<const MappedStep>)>& visit) {
  constexpr std::size_t kAtATime = 256;  // so few that they stay in the first-level cache
  std::array<MappedStep, kAtATime> steps;
  std::size_t next = 0, count = 0;
  walk(
      map, end, [&] { return next < segments.size() ? &segments[next++] : nullptr; },
      [&](const MappedStep& step) {
        steps[count++] = step;
        if (count < kAtATime) return;
        visit(steps);
        count = 0;
      });
  visit(std::span(steps).first(count));
}

Sizing size_gated_map(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, Duration lead) {
  Sizing sizing = size_map(setup, timing, kind);
  const auto with_lead = [&](LatencyBudget& budget, LatencyBudget gated) {
    budget.latency = gated.latency - gated.lead + lead;
    budget.latency_culprit = gated.latency_culprit;
  };
  const GateModel worst{lead, true}, here{lead, false};
  with_lead(sizing.any_phase, least_latency_any_phase(walk(setup, timing, kind, &worst), setup.grids, setup.emission));
  sizing.steps = walk(setup, timing, kind, &here);
  with_lead(sizing.this_phase, least_latency_this_phase(sizing.steps, setup.grids, setup.emission));
  return sizing;
}

AdaptiveLatency latency_of(const MapSetup& setup, const StrategyPlan& plan) {
  if (!plan.adapts) return plan.latency;
  AdaptiveLatencyOptions options = setup.remap.adapt;
  options.emission = setup.emission;
  return AdaptiveLatency(options);
}

AdaptationForecast forecast_adaptation(const Scenario& scenario, const StrategyPlan& plan) {
  AdaptationForecast forecast;
  RunningEmissions emissions(plan.lead, latency_of(map_setup(scenario), plan));
  std::int64_t sum_ns = 0, judged = 0;
  for (const MappedStep& step : plan.sizing.steps) {
    const StepEmission force = emissions.next(step);
    const Duration scheduled = force.at - force.slot.read;
    if (step.begin < RealTime{scenario.warmup.ns}) continue;
    ++judged;
    sum_ns += scheduled.ns;
    forecast.largest = std::max(forecast.largest, scheduled);
  }
  forecast.growths = emissions.latency().growths();
  if (judged > 0) forecast.mean_s = static_cast<double>(sum_ns) / static_cast<double>(judged) / 1e9;
  return forecast;
}

}  // namespace evenstep
