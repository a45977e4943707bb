#include "source_plan.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <vector>

#include "evenstep/time/reproducible_math.h"

namespace evenstep {

Duration needed_ahead(const MapSetup& setup, StrategyKind kind, Emission emission) {
  if (kind != StrategyKind::polyphase) return {};
  return setup.source_period * (setup.taps - (emission == Emission::linear ? 1 : 0));
}

namespace internal {
namespace {

struct Rule {
  StrategyKind kind;
  ChunkRule rule;
};
constexpr Rule kChunkRules[] = {{StrategyKind::chunk_replace, ChunkRule::replace},
                                {StrategyKind::chunk_append, ChunkRule::append},
                                {StrategyKind::chunk_blend, ChunkRule::blend}};
const Rule* chunk_rule(StrategyKind kind) {
  const auto* found =
      std::find_if(std::begin(kChunkRules), std::end(kChunkRules), [&](const Rule& one) { return one.kind == kind; });
  return found == std::end(kChunkRules) ? nullptr : found;
}

/// A step of a schedule without a map: its begin, which is the stamp of its force, and when the force reaches the device.
struct Made {
  RealTime begin, arrives;
  bool lost = false;
};
template <class Visit>
void each_made(const Scenario& scenario, Visit visit) {
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  const RealTime end{scenario.run_duration.ns};
  for (SegmentTiming segment; timing->next(segment) && segment.begin < end;) {
    for (const Interval& step : segment.steps) {
      const Transport way = segment.transport(step);
      visit(Made{step.begin, step.end + way.delay, way.lost});
    }
  }
}

/// The most entries from the oldest one that is still in use to a new one: max over n of n - m + 1 for the first m with
/// used(m) >= S(n). An entry is kept as long as an older one is.
class InUse {
 public:
  void add(RealTime begin, RealTime used) {
    while (!until_.empty() && until_.front() < begin) until_.pop_front();
    until_.push_back(until_.empty() ? used : std::max(until_.back(), used));
    most_ = std::max(most_, until_.size());
  }
  std::size_t most() const { return most_; }

 private:
  std::deque<RealTime> until_;
  std::size_t most_ = 0;
};

/// See StrategyPlan::least_entries.
std::int64_t least_entries(const Scenario& scenario) {
  const std::int64_t every = scenario.playing.chunk.every.ns;
  const RealTime end{scenario.run_duration.ns};
  std::int64_t most = 0;
  const auto played = [&](const Made& chunk, RealTime until) {
    most = std::max(most, ((until - chunk.begin).ns + every - 1) / every);
  };
  // The chunks that will be played, if none that is still to be made overtakes them: each is played until the next of them
  // arrives, the last one until the run ends. A chunk that comes after that is never played.
  std::deque<Made> chunks;
  each_made(scenario, [&](const Made& chunk) {
    if (chunk.lost || chunk.arrives >= end) return;
    while (!chunks.empty() && chunks.back().arrives >= chunk.arrives) chunks.pop_back();
    chunks.push_back(chunk);
    // What is made from now on cannot arrive before it is begun.
    while (chunks.size() > 1 && chunks[1].arrives < chunk.begin) {
      played(chunks[0], chunks[1].arrives);
      chunks.pop_front();
    }
  });
  for (std::size_t i = 0; i < chunks.size(); ++i) played(chunks[i], i + 1 < chunks.size() ? chunks[i + 1].arrives : end);
  return most;
}

/// The longest time between the slots of two neighbouring forces that are not lost.
Duration longest_gap(const Scenario& scenario, const StrategyPlan& plan) {
  Duration longest;
  std::optional<RealTime> before;
  each_run_step(scenario, plan, [&](std::span<const MappedStep> steps) {
    for (const MappedStep& step : steps) {
      if (step.lost) continue;
      if (before) longest = std::max(longest, step.slot - *before);
      before = step.slot;
    }
  });
  return longest;
}

}  // namespace

void add_room(const Scenario& scenario, StrategyPlan& plan) {
  constexpr std::size_t kSpare = 2;  // as in LatencyBudget
  if (plan.kind == StrategyKind::polyphase)
    plan.force_capacity += 2 * static_cast<std::size_t>(scenario.playing.resampler.taps);
  if (chunk_rule(plan.kind) != nullptr) plan.least_entries = least_entries(scenario);
  if (!scenario.timing.elsewhere && !traits_of(plan.kind).continues) return;
  const Duration delay = plan.latency - plan.lead;
  // A force stays in the ring until the tick that takes it out.
  Duration to_tick;
  for (const DeviceSpec& device : scenario.devices) to_tick = std::max(to_tick, Duration{instant_ns(device.rate, 1)});
  InUse forces;
  if (plan.sizing.has_steps()) {
    each_run_step(scenario, plan, [&](std::span<const MappedStep> steps) {
      for (const MappedStep& step : steps) forces.add(step.begin, std::max(step.slot + delay, step.end) + to_tick);
    });
  } else {
    each_made(scenario, [&](const Made& step) { forces.add(step.begin, step.arrives + to_tick); });
  }
  plan.force_capacity = std::max(plan.force_capacity, forces.most() + kSpare);
}

std::optional<SourceForces> source_forces(const Scenario& scenario, const StrategyPlan& plan, Emission emission) {
  if (traits_of(plan.kind).knows_motion) return std::nullopt;
  if (const Rule* chunks = chunk_rule(plan.kind)) {
    ChunkSpec spec = scenario.playing.chunk;
    spec.rule = chunks->rule;
    spec.between = emission;
    InUse entries;
    each_made(scenario,
              [&](const Made& step) { entries.add(step.begin, std::max(step.arrives, step.begin + spec.length())); });
    spec.most = 2 + entries.most();
    return SourceForces{spec};
  }
  ResamplerSpec spec = scenario.playing.resampler;
  spec.capacity = plan.force_capacity + 2 * static_cast<std::size_t>(spec.taps) + 1;
  if (plan.kind == StrategyKind::interpolated) {
    spec.kind = Resampling::interpolated;
    spec.period = {sim_time(scenario.scene.step_rate, 1).ns};
  } else if (plan.kind == StrategyKind::holt_winters)
    spec.kind = Resampling::holt_winters;
  else if (plan.kind == StrategyKind::polyphase)
    spec.kind = Resampling::polyphase;
  else if (!scenario.timing.elsewhere)
    return std::nullopt;
  else if (traits_of(plan.kind).plays_as_it_comes)
    spec.kind = Resampling::newest;
  else
    spec.kind = emission == Emission::hold ? Resampling::scheduled_held : Resampling::scheduled;
  return SourceForces{spec};
}

Duration memory_of(const SourceForces& source, const Scenario& scenario, const StrategyPlan& plan) {
  if (const auto* chunk = std::get_if<ChunkSpec>(&source.play)) return chunk->length();
  const ResamplerSpec& spec = std::get<ResamplerSpec>(source.play);
  if (spec.kind == Resampling::interpolated) return spec.period;
  if (spec.kind == Resampling::polyphase) return spec.period * spec.taps + longest_gap(scenario, plan);
  if (spec.kind != Resampling::holt_winters) return {};
  // The larger eigenvalue of its recurrence on a line (docs/choose/sources.md): determinant 1 - a, trace 2 - a - a g.
  const double determinant = 1 - spec.level, trace = 2 - spec.level - spec.level * spec.trend;
  const double gap = trace * trace / 4 - determinant;
  const double radius = gap < 0 ? std::sqrt(determinant) : trace / 2 + std::sqrt(gap);
  constexpr double kLeft = 1e-9;
  const double samples = radius > 0 ? reproducible::log(kLeft) / reproducible::log(radius) : 2;
  return spec.period * static_cast<std::int64_t>(std::min(std::ceil(samples) + 1, 1e6));
}

}  // namespace internal
}  // namespace evenstep
