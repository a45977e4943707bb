#include "evenstep/remap/latency_budget.h"

#include <algorithm>

namespace evenstep {
namespace {

/// slot(n) as the force side sees it, in step order: where a map steps back, SlotMap::emission repairs F(n) to
/// F(n-1) + 1 ns. The repair commutes with adding the constant L - c, so it can be made on the slots.
class EmissionSlots {
 public:
  RealTime next(RealTime slot) {
    if (last_ && slot <= *last_) slot = *last_ + Duration{1};
    last_ = slot;
    return slot;
  }

 private:
  std::optional<RealTime> last_;
};

struct Need {
  std::optional<Duration> least;
  std::int64_t culprit = -1;
  void require(Duration duration, std::int64_t step) {
    if (least && duration <= *least) return;
    least = duration;
    culprit = step;
  }
};

/// The newest sample is sure to be at this time or later when a step begins.
class NewestAnyPhase {
 public:
  explicit NewestAnyPhase(SamplingGrid device) : sampling_term_(period_ceil(device.rate) - Duration{1}) {}
  RealTime operator()(RealTime begin) const { return begin - sampling_term_; }

 private:
  Duration sampling_term_;
};

class NewestThisPhase {
 public:
  explicit NewestThisPhase(SamplingGrid device) : device_(device), period_(period_ceil(device.rate)) {
    const __int128 period = static_cast<__int128>(period_.ns) * device.rate.num;
    whole_ = period == static_cast<__int128>(device.rate.den) * 1'000'000'000;
  }
  RealTime operator()(RealTime begin) const {
    const auto& [rate, origin] = device_;
    if (!whole_) return tick_time(rate, first_tick_at_or_after(rate, begin + Duration{1}, origin) - 1, origin);
    const std::int64_t into = (begin - origin).ns % period_.ns;   // the usual case, without 128-bit divisions
    return begin - Duration{into < 0 ? into + period_.ns : into};
  }

 private:
  SamplingGrid device_;
  Duration period_;
  bool whole_ = false;                                            // the period is a whole number of ns
};

/// L - c: how long after its slot a force may be due at the earliest.
Need least_force_delay(std::span<const MappedStep> steps, Emission emission) {
  Need need;
  EmissionSlots slots;
  std::optional<RealTime> slot_before;
  for (const MappedStep& step : steps) {
    const RealTime slot = slots.next(step.slot);
    // Interpolated, a force is due when the interval that leads to it begins.
    const RealTime due = emission == Emission::linear && slot_before ? *slot_before : slot;
    need.require(step.end - due, step.step);
    slot_before = slot;
  }
  return need;
}

template <class Newest>
LatencyBudget least_needs(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices, Emission emission) {
  Need lead;
  for (const SamplingGrid& device : devices) {
    const Newest newest(device);
    for (const MappedStep& step : steps) lead.require(step.slot - newest(step.begin), step.step);
  }
  const Need delay = least_force_delay(steps, emission);
  const Duration c = lead.least.value_or(Duration{});
  return {c, delay.least.value_or(Duration{} - c) + c, lead.culprit, delay.culprit};
}

LatencyBudget with_capacities(LatencyBudget budget, std::span<const MappedStep> steps, std::span<const SamplingGrid> devices) {
  const LatencyBudget rings = capacities_for(steps, devices, budget.lead, budget.latency);
  budget.interaction_capacity = rings.interaction_capacity;
  budget.force_capacity = rings.force_capacity;
  return budget;
}

/// Most ticks of any phase in (R, S]: m of them span at least floor((m - 1) / rate), so m = ceil((S - R) * rate).
std::size_t most_ticks(Rate rate, Duration span) {
  return span.ns <= 0 ? 0 : static_cast<std::size_t>(first_tick_at_or_after(rate, RealTime{span.ns}));
}

/// max over n of #{m <= n: F(m) > F(n) - window}: forces that the line past force n starts behind.
std::size_t most_forces_within(std::span<const MappedStep> steps, Duration window) {
  std::size_t most = 0;
  std::size_t oldest = 0;                                // first m with F(m) > F(n) - window
  EmissionSlots newest_slots;
  EmissionSlots oldest_slots;
  RealTime oldest_slot = steps.empty() ? RealTime{} : oldest_slots.next(steps[0].slot);
  for (std::size_t n = 0; n < steps.size(); ++n) {
    const RealTime newest_slot = newest_slots.next(steps[n].slot);
    while (oldest < n && oldest_slot <= newest_slot - window) oldest_slot = oldest_slots.next(steps[++oldest].slot);
    most = std::max(most, n + 1 - oldest);
  }
  return window.ns <= 0 ? 0 : most;
}

/// max over n of #{m <= n: F(m) >= E(n)}: forces that wait when force n is pushed, itself included.
std::size_t most_waiting_forces(std::span<const MappedStep> steps, Duration delay) {
  std::size_t most = 0;
  std::size_t oldest = 0;                                // first m with F(m) >= E(n)
  EmissionSlots slots;
  RealTime oldest_emission = steps.empty() ? RealTime{} : slots.next(steps[0].slot) + delay;
  for (std::size_t n = 0; n < steps.size(); ++n) {
    while (oldest <= n && oldest_emission < steps[n].end) {
      if (++oldest < steps.size()) oldest_emission = slots.next(steps[oldest].slot) + delay;
    }
    most = std::max(most, n + 1 - oldest);
  }
  return most;
}

}  // namespace

LatencyBudget least_latency_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                      Emission emission) {
  return with_capacities(least_needs_any_phase(steps, devices, emission), steps, devices);
}

LatencyBudget least_latency_this_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                       Emission emission) {
  return with_capacities(least_needs<NewestThisPhase>(steps, devices, emission), steps, devices);
}

LatencyBudget least_needs_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                    Emission emission) {
  return least_needs<NewestAnyPhase>(steps, devices, emission);
}

LatencyBudget capacities_for(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices, Duration lead,
                             Duration latency, Duration sample_window, Duration force_window) {
  Duration longest;   // from a read to its step's begin; the ticks in it grow with it
  for (const MappedStep& step : steps) longest = std::max(longest, step.begin - (step.slot - lead));
  std::size_t most_samples = 0;
  for (const SamplingGrid& device : devices) {
    most_samples = std::max(most_samples, most_ticks(device.rate, std::max(sample_window, longest)));
  }
  LatencyBudget budget{lead, latency};
  budget.interaction_capacity = most_samples + 2;
  const std::size_t most_waiting = most_waiting_forces(steps, latency - lead);
  budget.force_capacity = std::max(most_waiting, most_forces_within(steps, force_window)) + 2;
  return budget;
}

std::vector<bool> interaction_underruns(std::span<const MappedStep> steps, SamplingGrid device, Duration lead) {
  const NewestThisPhase newest(device);
  std::vector<bool> underruns;
  underruns.reserve(steps.size());
  for (const MappedStep& step : steps) underruns.push_back(step.slot - lead > newest(step.begin));
  return underruns;
}

std::vector<bool> late_forces(std::span<const MappedStep> steps, Duration lead, AdaptiveLatency latency) {
  std::vector<bool> late;
  late.reserve(steps.size());
  for (const MappedStep& step : steps) late.push_back(step.end > latency.emission(step.slot - lead, step.end));
  return late;
}

std::int64_t count_interaction_underruns(std::span<const MappedStep> steps, SamplingGrid device, Duration lead) {
  const std::vector<bool> underruns = interaction_underruns(steps, device, lead);
  return std::count(underruns.begin(), underruns.end(), true);
}

std::int64_t count_late_forces(std::span<const MappedStep> steps, Duration lead, const AdaptiveLatency& latency) {
  const std::vector<bool> late = late_forces(steps, lead, latency);
  return std::count(late.begin(), late.end(), true);
}

}  // namespace evenstep
