// [remap]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sections.h"

namespace evenstep::internal {
namespace {

void read_underrun(ScenarioReading& reading, const Table& underrun) {
  RemapSpec& spec = reading.scenario.remap;
  const std::string interaction = underrun.text("interaction"), force = underrun.text("force");
  for (const InteractionUnderrun policy : {InteractionUnderrun::gate, InteractionUnderrun::extrapolate}) {
    if (interaction == name_of(policy)) spec.interaction_underrun = policy;
  }
  if (force == name_of(ForceUnderrun::hold)) return;
  spec.force_underrun = ForceUnderrun::extrapolate;
  for (const DeviceSpec& device : reading.scenario.devices) {
    if (device.emission == Emission::linear) continue;
    reading.errors.add(underrun.place("force"),
                       fmt::format("'force': \"extrapolate\" continues a line, and device '{}' has emission = \"hold\"; "
                                   "write emission = \"linear\" there, or force = \"hold\"",
                                   device.name));
  }
}

double in_Hz(Rate rate) { return static_cast<double>(rate.num) / static_cast<double>(rate.den); }

/// A filter of so slow a signal: the steps', or that of the slowest device's ticks.
Rate filtered_rate(const Scenario& scenario) {
  if (!scenario.remap.filter_force) return scenario.scene.step_rate;
  const auto slowest = std::min_element(scenario.devices.begin(), scenario.devices.end(),
                                        [](const auto& a, const auto& b) { return in_Hz(a.rate) < in_Hz(b.rate); });
  return slowest == scenario.devices.end() ? Rate{} : slowest->rate;
}

void read_filter(ScenarioReading& reading, const Table& filter) {
  RemapSpec& spec = reading.scenario.remap;
  spec.filter_force = filter.text("on") == "force";
  const double rate_Hz = in_Hz(filtered_rate(reading.scenario));
  const auto cutoff = [&](std::string_view key) {
    const double cutoff_Hz = in_Hz(filter.rate(key));
    if (!(cutoff_Hz < rate_Hz / 2)) {
      reading.errors.add(filter.place(key), fmt::format("'{}': {} Hz cannot be filtered out of a signal of {} Hz; it must be "
                                                        "below half of that",
                                                        key, cutoff_Hz, rate_Hz));
    }
    return cutoff_Hz;
  };
  const std::string kind = filter.text("kind");
  if (kind == "moving-average") {
    const Duration window = filter.span("window", reading.scenario.nominal, reading.errors);
    spec.filter = moving_average(std::max<std::int64_t>(1, std::llround(seconds(window) * rate_Hz)));
  } else if (kind == "butterworth") {
    spec.filter = butterworth(cutoff("cutoff"));
  } else {
    spec.filter = one_euro(cutoff("min_cutoff"), filter.number("beta"), cutoff("derivative_cutoff"));
  }
}

}  // namespace

void read_remap(ScenarioReading& reading) {
  if (!reading.sound("remap")) return;
  const Table remap = reading.section("remap");
  RemapSpec& spec = reading.scenario.remap;
  spec.estimate_weight = remap.table("estimate").number("weight");
  const Rate bandwidth = remap.rate("bandwidth");
  spec.bandwidth_Hz = static_cast<double>(bandwidth.num) / static_cast<double>(bandwidth.den);
  const auto budget = [&](std::string_view key) -> Budget {
    const std::string text = remap.text(key);
    if (text == "minimal") return {Budget::Kind::any_phase, {}};
    if (text == "minimal-this-phase") return {Budget::Kind::this_phase, {}};
    return {Budget::Kind::fixed, remap.span(key, reading.scenario.nominal, reading.errors)};
  };
  spec.latency = budget("latency");
  spec.lead = budget("lead");
  spec.predict_window = remap.span("predict_window", reading.scenario.nominal, reading.errors);
  read_underrun(reading, remap.table("underrun"));
  read_filter(reading, remap.table("filter"));
}

}  // namespace evenstep::internal
