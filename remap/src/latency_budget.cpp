#include "evenstep/remap/latency_budget.h"

#include <algorithm>

namespace evenstep {
namespace {

using internal::EmissionSlots;
using internal::NewestThisPhase;

/// The time that the newest sample is sure to have reached when a step begins, at any phase of the device.
class NewestAnyPhase {
 public:
  explicit NewestAnyPhase(SamplingGrid device) : sampling_term_(period_ceil(device.rate) - Duration{1} + device.age) {}
  RealTime operator()(RealTime begin) const { return begin - sampling_term_; }

 private:
  Duration sampling_term_;
};

LatencyBudget needs_of(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices, Emission emission,
                       RunningNeeds::Phase phase) {
  RunningNeeds needs(devices, emission, phase);
  needs.add(steps);
  return needs.budget();
}

LatencyBudget with_capacities(LatencyBudget budget, std::span<const MappedStep> steps,
                              std::span<const SamplingGrid> devices) {
  const LatencyBudget rings = capacities_for(steps, devices, budget.lead, budget.latency);
  budget.interaction_capacity = rings.interaction_capacity;
  budget.force_capacity = rings.force_capacity;
  return budget;
}

/// The most ticks, at any phase, in (R, S]: m of them span at least floor((m - 1) / rate), so m = ceil((S - R) * rate).
std::size_t most_ticks(Rate rate, Duration span) {
  return span.ns <= 0 ? 0 : static_cast<std::size_t>(first_tick_at_or_after(rate, RealTime{span.ns}));
}

}  // namespace

NewestThisPhase::NewestThisPhase(SamplingGrid device) : device_(device), period_(period_ceil(device.rate)) {
  const __int128 period = static_cast<__int128>(period_.ns) * device.rate.num;
  whole_ = period == static_cast<__int128>(device.rate.den) * 1'000'000'000;
  per_ns_ = 1 / static_cast<double>(period_.ns);
}

RealTime NewestThisPhase::operator()(RealTime begin) const {
  if (!whole_) return newest_sample(device_, begin);
  // The usual case, without an integer division: below 2^50 ns (13 days) the quotient is off by 1 at most.
  const std::int64_t since = (begin - device_.origin).ns;
  const bool near = since > -(std::int64_t{1} << 50) && since < (std::int64_t{1} << 50);
  std::int64_t into =
      near ? since - static_cast<std::int64_t>(static_cast<double>(since) * per_ns_) * period_.ns : since % period_.ns;
  if (into < 0) into += period_.ns;
  if (into >= period_.ns) into -= period_.ns;
  return begin - Duration{into} - device_.age;
}

RunningNeeds::RunningNeeds(std::span<const SamplingGrid> devices, Emission emission, Phase phase)
    : devices_(devices.begin(), devices.end()), emission_(emission), phase_(phase), leads_(devices.size()) {}

void RunningNeeds::add(std::span<const MappedStep> steps) {
  for (std::size_t i = 0; i < devices_.size(); ++i) {
    const auto require = [&](const auto& newest) {
      Need lead = leads_[i];
      for (const MappedStep& step : steps) lead.require(step.slot - newest(step.begin), step.step);
      leads_[i] = lead;
    };
    if (phase_ == Phase::any)
      require(NewestAnyPhase(devices_[i]));
    else
      require(NewestThisPhase(devices_[i]));
  }
  // Copied to local variables, which stay in registers.
  Need wait = wait_, delay = delay_;
  EmissionSlots slots = slots_;
  internal::LineStarts lines = lines_;
  const bool linear = emission_ == Emission::linear;
  for (const MappedStep& step : steps) {
    wait.require(step.begin - step.slot, step.step);
    const RealTime slot = slots.next(step.slot);
    const RealTime line_from = lines.next(slot, step.lost);
    if (!step.lost) delay.require(step.end - (linear ? line_from : slot), step.step);
  }
  wait_ = wait;
  delay_ = delay;
  slots_ = slots;
  lines_ = lines;
}

void RunningNeeds::restart() {
  restart_needs();
  slots_ = {};
  lines_ = {};
}

void RunningNeeds::restart_needs() {
  leads_.assign(devices_.size(), {});
  delay_ = wait_ = {};
}

LatencyBudget RunningNeeds::budget() const {
  if (delay_.culprit < 0) return {};
  Need lead;
  for (const Need& one : leads_) lead.require(one.least, one.culprit);
  return {.lead = lead.least,
          .latency = delay_.least + lead.least,
          .lead_culprit = lead.culprit,
          .latency_culprit = delay_.culprit};
}

std::size_t RunningNeeds::interaction_capacity() const {
  const Duration longest = std::max(wait_.least + budget().lead, Duration{});
  std::size_t most = 0;
  for (const SamplingGrid& device : devices_) most = std::max(most, most_ticks(device.rate, longest));
  return most + 2;
}

void WaitingForces::add(std::span<const MappedStep> steps) {
  for (const MappedStep& step : steps) {
    emissions_.push_back(slots_.next(step.slot) + delay_);
    while (!emissions_.empty() && emissions_.front() < step.end) emissions_.pop_front();
    most_ = std::max(most_, emissions_.size());
  }
}

void ForcesWithin::add(std::span<const MappedStep> steps) {
  if (window_.ns <= 0) return;
  for (const MappedStep& step : steps) {
    within_.push_back(slots_.next(step.slot));
    while (within_.front() <= within_.back() - window_) within_.pop_front();
    most_ = std::max(most_, within_.size());
  }
}

RunningCapacities::RunningCapacities(std::span<const SamplingGrid> devices, Duration lead, Duration latency,
                                     Duration sample_window, Duration force_window)
    : devices_(devices.begin(), devices.end()),
      lead_(lead),
      latency_(latency),
      longest_(sample_window),
      waiting_(latency - lead),
      within_(force_window) {}

void RunningCapacities::add(std::span<const MappedStep> steps) {
  for (const MappedStep& step : steps) longest_ = std::max(longest_, step.begin - (step.slot - lead_));
  waiting_.add(steps);
  within_.add(steps);
}

LatencyBudget RunningCapacities::budget() const {
  std::size_t most_samples = 0;
  for (const SamplingGrid& device : devices_) most_samples = std::max(most_samples, most_ticks(device.rate, longest_));
  LatencyBudget budget{lead_, latency_};
  budget.interaction_capacity = most_samples + 2;
  budget.force_capacity = std::max(waiting_.most(), within_.most()) + 2;
  return budget;
}

LatencyBudget least_latency_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                      Emission emission) {
  return with_capacities(least_needs_any_phase(steps, devices, emission), steps, devices);
}

LatencyBudget least_latency_this_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                       Emission emission) {
  return with_capacities(needs_of(steps, devices, emission, RunningNeeds::Phase::this_one), steps, devices);
}

LatencyBudget least_needs_any_phase(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices,
                                    Emission emission) {
  return needs_of(steps, devices, emission, RunningNeeds::Phase::any);
}

LatencyBudget capacities_for(std::span<const MappedStep> steps, std::span<const SamplingGrid> devices, Duration lead,
                             Duration latency, Duration sample_window, Duration force_window) {
  RunningCapacities capacities(devices, lead, latency, sample_window, force_window);
  capacities.add(steps);
  return capacities.budget();
}

RealTime newest_sample(const SamplingGrid& device, RealTime at) {
  const std::int64_t next = first_tick_at_or_after(device.rate, at + Duration{1}, device.origin);
  return tick_time(device.rate, next - 1, device.origin) - device.age;
}

RunningUnderruns::RunningUnderruns(SamplingGrid device, Duration lead, const AdaptiveLatency& latency, Emission emission,
                                   Duration ahead)
    : newest_(device), emissions_(lead, latency), emission_(emission), ahead_(ahead) {}

RunningUnderruns::Step RunningUnderruns::next(const MappedStep& step) {
  const StepEmission force = emissions_.next(step);
  return {std::max(force.slot.read - newest_(step.begin), Duration{}), force.late(emission_, ahead_)};
}

std::int64_t count_interaction_underruns(std::span<const MappedStep> steps, SamplingGrid device, Duration lead) {
  const NewestThisPhase newest(device);
  return std::count_if(steps.begin(), steps.end(),
                       [&](const MappedStep& step) { return step.slot - lead > newest(step.begin); });
}

std::int64_t count_late_forces(std::span<const MappedStep> steps, Duration lead, const AdaptiveLatency& latency,
                               Emission emission) {
  RunningUnderruns underruns({}, lead, latency, emission);
  return std::count_if(steps.begin(), steps.end(),
                       [&](const MappedStep& step) { return underruns.next(step).late_by.ns > 0; });
}

}  // namespace evenstep
