#include "evenstep/harness/live_figures.h"

#include <algorithm>
#include <cmath>

namespace evenstep {
namespace {

/// The smallest value that at least `percent` of the sorted list does not exceed (nearest rank); 0 of an empty one.
Duration percentile(const std::vector<std::int64_t>& sorted_ns, std::size_t percent) {
  if (sorted_ns.empty()) return {};
  return {sorted_ns[std::max<std::size_t>((sorted_ns.size() * percent + 99) / 100, 1) - 1]};
}

/// Armed or waiting, ramping, cut.
int badness(GuardState state) { return state >= GuardState::cut_device ? 2 : state == GuardState::ramping ? 1 : 0; }

void add_margin(Duration margin, std::optional<Duration>& least) { least = std::min(margin, least.value_or(margin)); }

LiveCounts operator-(const LiveCounts& a, const LiveCounts& b) {
  return {a.ticks - b.ticks, a.steps - b.steps, a.missed - b.missed, a.late_reads - b.late_reads,
          a.late_forces - b.late_forces};
}

}  // namespace

WatchedRun watched_run(const Scenario& scenario, const LiveDeviceOptions& options) {
  WatchedRun run{scenario.name, name_of(scenario.live), scenario.run_duration, {}};
  for (const DeviceSpec& device : scenario.devices)
    run.devices.push_back(
        {device.name, device.rate, RealTime{device.phase.ns}, device.limits.max_N, !device.is_real || options.forces});
  return run;
}

void LiveSnapshot::Device::add(GuardState seen) {
  if (!guard || badness(seen) >= badness(*guard)) guard = seen;
}

LiveFigures::LiveFigures(const WatchedRun& run) : run_(run), devices_(run.devices.size()) {}

void LiveFigures::add(const SeenTick& tick) {
  Device& device = devices_[tick.tool];
  const WatchedRun::Device& known = run_.devices[tick.tool];
  device.ran = tick.ran;
  device.due = first_tick_at_or_after(known.rate, tick.scheduled, known.first_tick) + 1;
  const glm::dvec3& f = tick.force_N;
  device.last.force_N = std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z);
  device.last.add(tick.guard);
  lateness_ns_.push_back(tick.lateness.ns);
  last_.lateness_max = std::max(last_.lateness_max, tick.lateness);
  last_.clamped += tick.saturated.has(SaturationCause::clamp);
}

void LiveFigures::add(const SeenStep& step) {
  counts_.steps = step.number + 1;
  counts_.late_reads = step.late_reads;
  counts_.late_forces = step.late_forces;
  if (!step.mapped) return;
  add_margin(step.force_margin, last_.least_margin);
  for (std::size_t tool = 0; tool < devices_.size(); ++tool) add_margin(step.tools[tool].sample_margin, last_.least_margin);
}

LiveCounts LiveFigures::counts(RealTime now) const {
  LiveCounts counts = counts_;
  const RealTime end{run_.length.ns};
  for (std::size_t d = 0; d < devices_.size(); ++d) {
    std::int64_t due = devices_[d].due;
    // No later tick tells of those that the run's end came before.
    if (now >= end) due = std::max(due, first_tick_at_or_after(run_.devices[d].rate, end, run_.devices[d].first_tick));
    counts.ticks += devices_[d].ran;
    counts.missed += due - devices_[d].ran;
  }
  return counts;
}

LiveSnapshot LiveFigures::take(RealTime now, std::uint64_t dropped) {
  LiveSnapshot snapshot;
  snapshot.now = now;
  snapshot.left = std::max(RealTime{run_.length.ns} - now, Duration{});
  snapshot.span = now - taken_at_;
  snapshot.dropped = dropped;
  std::sort(lateness_ns_.begin(), lateness_ns_.end());
  snapshot.lateness_p50 = percentile(lateness_ns_, 50);
  snapshot.lateness_p99 = percentile(lateness_ns_, 99);
  whole_.counts = counts(now);
  last_.counts = whole_.counts - counts_before_;
  whole_.lateness_max = std::max(whole_.lateness_max, last_.lateness_max);
  whole_.clamped += last_.clamped;
  if (last_.least_margin) add_margin(*last_.least_margin, whole_.least_margin);
  snapshot.last = last_;
  snapshot.whole = whole_;
  for (Device& device : devices_) {
    snapshot.devices.push_back(device.last);
    device.last.guard.reset();
  }
  counts_before_ = whole_.counts;
  last_ = {};
  lateness_ns_.clear();
  taken_at_ = now;
  return snapshot;
}

}  // namespace evenstep
