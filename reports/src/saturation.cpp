#include "evenstep/reports/saturation.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "src/fits/straight.h"
#include "src/judged.h"
#include "src/saturated_samples.h"

namespace evenstep {
namespace {

/// `at(i)`: the time of sample i.
template <class At>
Saturation summary(const std::vector<SaturationCauses>& met, At at) {
  Saturation saturation;
  saturation.judged = std::ssize(met);
  saturation.saturated = std::count_if(met.begin(), met.end(), [](SaturationCauses causes) { return !causes.none(); });
  for (const SaturationCause cause : kAllSaturationCauses) {
    const auto has = [&](SaturationCauses causes) { return causes.has(cause); };
    const auto first = std::find_if(met.begin(), met.end(), has);
    if (first == met.end()) continue;
    saturation.parts.push_back({cause, at(static_cast<std::size_t>(first - met.begin())),
                                static_cast<std::int64_t>(std::count_if(first, met.end(), has))});
  }
  std::stable_sort(saturation.parts.begin(), saturation.parts.end(),
                   [](const Saturation::Part& a, const Saturation::Part& b) { return a.first < b.first; });
  return saturation;
}

}  // namespace

std::string_view name_of(SaturationCause cause) {
  switch (cause) {
    case SaturationCause::clamp:
      return "clamp";
    case SaturationCause::slew:
      return "slew";
    case SaturationCause::cut:
      return "cut";
    case SaturationCause::non_finite:
      return "non_finite";
    case SaturationCause::device_force:
      return "device_force";
    case SaturationCause::device_position:
      return "device_position";
  }
  return "";
}

std::string text(const Saturation& saturation) {
  const Saturation::Part& first = saturation.parts.front();
  return fmt::format("{} of {} judged samples ({:.3g} %), {} first at {:.6g} s", saturation.saturated, saturation.judged,
                     100 * saturation.share(), name_of(first.cause), seconds(first.first));
}

std::map<std::string, Saturation> saturations(const RunRecord& run) {
  std::map<std::string, Saturation> found;
  const auto keep = [&](const std::string& signal, Saturation saturation) {
    if (saturation.saturated > 0) found.emplace(signal, std::move(saturation));
  };
  for (const StrategyRecord& strategy : run.strategies) {
    const Rows<std::size_t> steps = internal::judged_steps(strategy, run.nominal);
    for (const DeviceRecord& device : strategy.devices) {
      const Rows<std::size_t> ticks = internal::judged_ticks(device, run.nominal);
      keep(device.name + ".interaction." + strategy.name,
           summary(internal::saturation_of_steps(strategy, device, steps),
                   [&](std::size_t i) { return strategy.steps[steps[i]].begin; }));
      keep(device.name + ".force." + strategy.name,
           summary(internal::saturation_of_ticks(strategy, device, ticks),
                   [&](std::size_t i) { return internal::sent_at(device.ticks[ticks[i]]); }));
    }
  }
  return found;
}

namespace internal {
namespace {

bool ever_at_range(const DeviceRecord& device) {
  return std::any_of(device.ticks.begin(), device.ticks.end(),
                     [](const TickRow& tick) { return tick.saturated.has(SaturationCause::device_position); });
}

/// Whether a sample from which the step's position is made was at the end of the device's range: the newest one at its read
/// time and, if that lies between two samples, also the next one.
bool read_at_range(const StepRow& step, const Rows<TickRow>& ticks) {
  const auto at_range = [](const TickRow& tick) { return tick.saturated.has(SaturationCause::device_position); };
  const auto next = std::upper_bound(ticks.begin(), ticks.end(), std::min(step.read, step.begin),
                                     [](RealTime at, const TickRow& tick) { return at < sent_at(tick); });
  return (next != ticks.begin() && at_range(*(next - 1))) || (step.mapped && next != ticks.end() && at_range(*next));
}

}  // namespace

std::vector<SaturationCauses> saturation_of_steps(const StrategyRecord& strategy, const DeviceRecord& device,
                                                  std::span<const std::size_t> steps) {
  std::vector<SaturationCauses> met(steps.size());
  if (strategy.reference || !ever_at_range(device)) return met;
  for (std::size_t i = 0; i < steps.size(); ++i)
    met[i].add(SaturationCause::device_position, read_at_range(strategy.steps[steps[i]], device.ticks));
  return met;
}

std::vector<SaturationCauses> saturation_of_ticks(const StrategyRecord& strategy, const DeviceRecord& device,
                                                  std::span<const std::size_t> ticks) {
  std::vector<SaturationCauses> met;
  for (const std::size_t k : ticks) met.push_back(device.ticks[k].saturated);
  if (strategy.reference || !ever_at_range(device)) return met;
  const Rows<std::int64_t> sent = sent_steps(strategy, device);
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    // The force may lie between that of the step that is sent and that of the next step.
    for (const std::int64_t n : {sent[ticks[i]], sent[ticks[i]] + 1}) {
      if (n < 0 || n >= std::ssize(strategy.steps)) continue;
      met[i].add(SaturationCause::device_position, read_at_range(strategy.steps[static_cast<std::size_t>(n)], device.ticks));
    }
  }
  return met;
}

}  // namespace internal
}  // namespace evenstep
