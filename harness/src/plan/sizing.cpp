#include "evenstep/harness/sizing.h"

#include <algorithm>
#include <array>

#include "evenstep/loop/segment_pace.h"
#include "strategies.h"

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

/// Hands steps on a few at a time: so few that they stay in the first-level cache.
class Batches {
 public:
  explicit Batches(const VisitSteps& visit) : visit_(visit) {}
  void add(const MappedStep& step) {
    steps_[count_++] = step;
    if (count_ == steps_.size()) finish();
  }
  void finish() {
    visit_(std::span(steps_).first(count_));
    count_ = 0;
  }

 private:
  const VisitSteps& visit_;
  std::array<MappedStep, 256> steps_;
  std::size_t count_ = 0;
};

/// The haptic loop without its lanes and without a gate: visits every mapped step that ends before `end`. `next` returns
/// the segments one by one, and a null pointer at the end.
template <class Next>
void walk(SlotMap& map, RealTime end, Next next, const VisitSteps& visit) {
  Batches steps(visit);
  std::int64_t n = 0;
  for (const SegmentTiming* segment = next(); segment != nullptr && segment->begin < end; segment = next()) {
    map.boundary(n, segment->begin);
    for (const Interval& step : segment->steps) {
      const Transport way = segment->transport(step);
      if (const auto t = segment->simulated_at(step)) map.simulated(*t);
      const Slot slot = map.read(n, step.begin);
      map.emission(n, step.end + way.delay);
      if (slot.kind == SlotKind::mapped && step.end < end)
        steps.add({n, step.begin, step.end + way.delay, slot.read, segment->index, way.lost});
      ++n;
    }
  }
  steps.finish();
}

/// The same with a gate, which pushes back everything after a wait.
void walk_gated(const MapSetup& setup, StepTiming& timing, SlotMap& map, const GateModel& gate, const VisitSteps& visit) {
  Batches steps(visit);
  Postponement pushed;
  SegmentTiming segment;
  for (std::int64_t n = 0; timing.next(segment) && pushed.begin(segment.begin) < setup.end;) {
    map.boundary(n, segment.begin);
    const Pause pause = pause_of(segment, segment.overlaps());
    if (pause.before_steps) pushed.end(segment.visualization->end);
    for (const Interval& step : segment.steps) {
      RealTime began = pushed.begin(step.begin);
      if (const auto t = segment.simulated_at(step)) map.simulated(*t);
      const Slot slot = map.read(n, began, pushed.by());
      const RealTime launched = began;
      for (const SamplingGrid& grid : setup.grids) began = std::max(began, gate.opens(slot, grid));
      pushed.wait(began - launched);
      const RealTime ended = pushed.end(step.end);
      const Transport way = segment.transport(step);
      if (slot.kind == SlotKind::mapped && ended < setup.end)
        steps.add({n, began, ended + way.delay, slot.read, segment.index, way.lost});
      map.emission(n, ended + way.delay, pushed.by());
      ++n;
    }
    if (pause.after_steps) pushed.end(segment.visualization->end);
  }
  steps.finish();
}

void walk_timing(const MapSetup& setup, const TimingSpec& timing_spec, StrategyKind kind, const GateModel* gate,
                 const VisitSteps& visit) {
  const std::unique_ptr<StepTiming> timing = make_timing(timing_spec);
  const std::unique_ptr<SlotMap> map = make_map(setup, kind, {}, Duration{});
  SegmentTiming segment;
  if (gate)
    walk_gated(setup, *timing, *map, *gate, visit);
  else
    walk(
        *map, setup.end, [&] { return timing->next(segment) ? &segment : nullptr; }, visit);
}

LatencyBudget needs_of(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, const GateModel& gate) {
  RunningNeeds needs(setup.grids, setup.emission, gate.any_phase ? RunningNeeds::Phase::any : RunningNeeds::Phase::this_one);
  walk_timing(setup, timing, kind, &gate, [&](std::span<const MappedStep> steps) { needs.add(steps); });
  return needs.budget();
}

/// Whether the loop keeps its own simulation time.
bool keeps_time(const TimingSpec& timing) {
  return timing.trace.empty() ? timing.programmed.accumulator.has_value() : has_clock(timing.trace);
}

/// What is programmed or recorded, with the governor. `real`: its steps have no length.
std::unique_ptr<StepTiming> governed(const TimingSpec& timing, bool real) {
  if (!timing.trace.empty())
    return timing.governor ? make_governed_replay(timing.trace, *timing.governor) : make_replayed_timing(timing.trace);
  std::unique_ptr<StepTiming> steps = make_programmed_timing(timing.programmed);
  if (real) steps = make_real_steps(std::move(steps));
  if (!timing.governor) return steps;
  std::optional<Duration> grid = grid_period(timing.programmed);
  // Segments of one length keep to a grid; real steps may leave idle time in it.
  if (real && is_periodic(timing.programmed)) grid = Duration{instant_ns(timing.programmed.segment, 1)};
  return make_governed_timing(std::move(steps), *timing.governor, grid);
}

}  // namespace

std::unique_ptr<StepTiming> make_timing(const TimingSpec& timing) {
  std::unique_ptr<StepTiming> steps = governed(timing, false);
  if (!timing.elsewhere) return steps;
  SourceSpec source = *timing.elsewhere;
  source.seed = timing.programmed.seed;  // further seeds of a run are set there
  return make_source_timing(std::move(steps), source);
}

std::unique_ptr<StepTiming> make_wall_timing(const TimingSpec& timing) {
  if (!timing.real_steps) return make_timing(timing);
  if (timing.governor && timing.governor->spread) return governed(timing, true);
  return make_real_steps(make_timing(timing));
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
          .has_clock = keeps_time(scenario.timing),
          .taps = scenario.playing.resampler.taps};
}

std::unique_ptr<SlotMap> make_map(const MapSetup& setup, StrategyKind kind, Duration lead, const AdaptiveLatency& latency) {
  return internal::strategy_of(kind).map(setup, lead, latency);
}

Sizing size_map(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind) {
  RunningNeeds any(setup.grids, setup.emission, RunningNeeds::Phase::any);
  RunningNeeds here(setup.grids, setup.emission, RunningNeeds::Phase::this_one);
  walk_timing(setup, timing, kind, nullptr, [&](std::span<const MappedStep> steps) {
    any.add(steps);
    here.add(steps);
  });
  Sizing sizing{any.budget(), here.budget()};
  const Duration ahead = needed_ahead(setup, kind, setup.emission);
  for (LatencyBudget* least : {&sizing.any_phase, &sizing.this_phase}) least->latency = least->latency + ahead;
  return sizing;
}

Sizing size_gated_map(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, Duration lead) {
  Sizing sizing = size_map(setup, timing, kind);
  const auto with_lead = [&](LatencyBudget& budget, const LatencyBudget& gated) {
    budget.latency = gated.latency - gated.lead + lead;
    budget.latency_culprit = gated.latency_culprit;
  };
  with_lead(sizing.any_phase, needs_of(setup, timing, kind, {lead, true}));
  with_lead(sizing.this_phase, needs_of(setup, timing, kind, {lead, false}));
  return sizing;
}

void each_run_step(const MapSetup& setup, const TimingSpec& timing, StrategyKind kind, Duration lead,
                   const VisitSteps& visit) {
  const GateModel here{lead, false};
  const bool gated = is_remap(kind) && setup.remap.interaction_underrun == InteractionUnderrun::gate;
  walk_timing(setup, timing, kind, gated ? &here : nullptr, visit);
}

void each_run_step(const Scenario& scenario, const StrategyPlan& plan, const VisitSteps& visit) {
  each_run_step(map_setup(scenario), scenario.timing, plan.kind, plan.lead, visit);
}

void each_mapped_step(const MapSetup& setup, StrategyKind kind, std::span<const SegmentTiming> segments,
                      const VisitSteps& visit) {
  each_mapped_step(*make_map(setup, kind, {}, Duration{}), setup.end, segments, visit);
}

void each_mapped_step(SlotMap& map, RealTime end, std::span<const SegmentTiming> segments, const VisitSteps& visit) {
  std::size_t next = 0;
  walk(
      map, end, [&] { return next < segments.size() ? &segments[next++] : nullptr; }, visit);
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
  each_run_step(scenario, plan, [&](std::span<const MappedStep> steps) {
    for (const MappedStep& step : steps) {
      const StepEmission force = emissions.next(step);
      const Duration scheduled = force.at - force.slot.read;
      if (step.begin < RealTime{scenario.warmup.ns}) continue;
      ++judged;
      sum_ns += scheduled.ns;
      forecast.largest = std::max(forecast.largest, scheduled);
    }
  });
  forecast.growths = emissions.latency().growths();
  if (judged > 0) forecast.mean_s = static_cast<double>(sum_ns) / static_cast<double>(judged) / 1e9;
  return forecast;
}

}  // namespace evenstep
