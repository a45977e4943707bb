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
    if (device.render.kind != RenderSpec::Kind::force) {
      reading.errors.add(underrun.place("force"),
                         fmt::format("'force': \"extrapolate\" continues a line of forces, and device '{}' makes its forces of "
                                     "records that answer the hand by themselves; write \"hold\"",
                                     device.name));
    }
    if (device.emission == Emission::linear) continue;
    reading.errors.add(underrun.place("force"),
                       fmt::format("'force': \"extrapolate\" continues a line, and device '{}' has emission = \"hold\"; "
                                   "write emission = \"linear\" there, or force = \"hold\"",
                                   device.name));
  }
}

/// The rates of the signals that the filter would be used on: that of the steps, or those of the devices' ticks.
std::vector<Rate> filtered_rates(const Scenario& scenario) {
  if (!scenario.remap.filter_force) return {scenario.scene.step_rate};
  std::vector<Rate> rates;
  for (const DeviceSpec& device : scenario.devices) rates.push_back(device.rate);
  return rates;
}

void read_filter(ScenarioReading& reading, const Table& filter) {
  RemapSpec& spec = reading.scenario.remap;
  spec.filter_force = filter.text("on") == "force";
  const std::string kind = filter.text("kind");
  std::string_view limited = "cutoff";
  if (kind == "butterworth") {
    spec.filter = ButterworthSpec{in_Hz(filter.rate("cutoff"))};
  } else if (kind == "one-euro") {
    limited = "min_cutoff";
    spec.filter = OneEuroSpec{in_Hz(filter.rate("min_cutoff")), filter.number("beta"),
                              in_Hz(filter.rate("derivative_cutoff"))};
  } else {
    limited = "window";
    spec.filter = MovingAverageSpec{};
    spec.filter_window = filter.span("window", reading.scenario.nominal, reading.errors);
  }
  const std::vector<StrategyKind>& strategies = reading.scenario.strategies;
  const bool used = std::find(strategies.begin(), strategies.end(), StrategyKind::filtered) != strategies.end();
  for (const Rate rate : used ? filtered_rates(reading.scenario) : std::vector<Rate>{}) {
    if (in_domain(filter_at(spec, rate), rate)) continue;
    reading.errors.add(filter.place(limited),
                       limited == "window"
                           ? fmt::format("'window': more than {} samples of {} Hz", kMaxAveragedSamples, in_Hz(rate))
                           : fmt::format("'{}': \"{}\" cannot be filtered out of a signal of {} Hz; it must be below half of "
                                         "that",
                                         limited, filter.text(limited), in_Hz(rate)));
  }
}

/// Reads the table of an adaptive latency. Values that must fit each other are checked only if it is used.
void read_adapt(ScenarioReading& reading, const Table& remap) {
  const NominalUnits& nominal = reading.scenario.nominal;
  const Table adapt = remap.table("adapt");
  AdaptiveLatencyOptions& options = reading.scenario.remap.adapt;
  options.least = adapt.span("min", nominal, reading.errors);
  options.most = adapt.span("max", nominal, reading.errors);
  options.start = adapt.has("start") ? adapt.span("start", nominal, reading.errors) : options.least;
  options.window = adapt.span("window", nominal, reading.errors);
  options.margin = adapt.span("margin", nominal, reading.errors);
  options.slew_ppm = std::llround(adapt.si("slew") * 1e6);
  Budget& latency = reading.scenario.remap.latency;
  if (latency.kind != Budget::Kind::adaptive) return;
  latency.fixed = options.most;
  if (options.least > options.start || options.start > options.most) {
    reading.errors.add(adapt.place(adapt.has("start") ? "start" : "max"),
                       fmt::format("'adapt': min {}, start {} and max {} must not decrease", in_ms(options.least),
                                   in_ms(options.start), in_ms(options.most)));
  }
  const std::vector<StrategyKind>& strategies = reading.scenario.strategies;
  if (std::none_of(strategies.begin(), strategies.end(), is_remap)) {
    reading.errors.add(remap.place("latency"), "'latency': only paper and phase_locked have one that can adapt, and [run] "
                                               "strategies names neither; add one, or give a duration");
  }
  for (const DeviceSpec& device : reading.scenario.devices) {
    if (!device.render.is_local() || device.render.alpha) continue;
    reading.errors.add(remap.place("latency"),
                       fmt::format("'latency': device '{}' takes its alpha from the latency, which \"adaptive\" does not "
                                   "know beforehand; write alpha as a number there, or a duration here",
                                   device.name));
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
    if (text == "adaptive") return {Budget::Kind::adaptive, {}};
    return {Budget::Kind::fixed, remap.span(key, reading.scenario.nominal, reading.errors)};
  };
  spec.latency = budget("latency");
  spec.lead = budget("lead");
  read_adapt(reading, remap);
  spec.predict_window = remap.span("predict_window", reading.scenario.nominal, reading.errors);
  read_underrun(reading, remap.table("underrun"));
  read_filter(reading, remap.table("filter"));
}

}  // namespace evenstep::internal
