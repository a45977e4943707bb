// [remap]
#include <fmt/format.h>

#include <algorithm>

#include "src/field_rows.h"
#include "src/sections.h"

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
    if (!std::holds_alternative<ForceRender>(device.render)) {
      reading.errors.add(
          underrun.place("force"),
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
    spec.filter =
        OneEuroSpec{in_Hz(filter.rate("min_cutoff")), filter.number("beta"), in_Hz(filter.rate("derivative_cutoff"))};
  } else {
    limited = "window";
    spec.filter = MovingAverageSpec{};
    spec.filter_window = filter.span("window", reading.scenario.nominal, reading.errors);
  }
  const std::vector<StrategyKind>& strategies = reading.scenario.strategies;
  const bool used =
      std::any_of(strategies.begin(), strategies.end(), [](StrategyKind one) { return traits_of(one).filters; });
  for (const Rate rate : used ? filtered_rates(reading.scenario) : std::vector<Rate>{}) {
    if (in_domain(filter_at(spec, rate), rate)) continue;
    reading.errors.add(
        filter.place(limited),
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
  options.slew_ppm = adapt.whole_ppm("slew", reading.errors);
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
    reading.errors.add(remap.place("latency"),
                       "'latency': only strategies that map have one that can adapt, and [run] "
                       "strategies names none; add phase_locked, or give a duration");
  }
  for (const DeviceSpec& device : reading.scenario.devices) {
    const auto* local = std::get_if<LocalRender>(&device.render);
    if (!local || local->alpha) continue;
    reading.errors.add(remap.place("latency"),
                       fmt::format("'latency': device '{}' takes its alpha from the latency, which \"adaptive\" does not "
                                   "know beforehand; write alpha as a number there, or a duration here",
                                   device.name));
  }
}

void read_rings(ScenarioReading& reading, const Table& remap) {
  if (!remap.has("rings")) return;
  const std::vector<Value> sizes = remap.at("rings").list;
  if (sizes.size() != 2) {
    return reading.errors.add(remap.place("rings"),
                              "'rings': a device has two, one of samples and one of forces; write rings = [64, 32]");
  }
  if (reading.scenario.timing.elsewhere) {
    return reading.errors.add(remap.place("rings"),
                              "'rings' are those between loops of one machine, and [source] plays forces of another one; "
                              "remove it");
  }
  const auto size = [&](std::size_t i) { return static_cast<std::size_t>(sizes[i].integer); };
  reading.scenario.remap.rings = {size(0), size(1)};
}

/// The map of strategy `foreign`.
void read_foreign_map(ScenarioReading& reading, const Table& remap) {
  const std::vector<StrategyKind>& strategies = reading.scenario.strategies;
  if (remap.has("foreign")) {
    ForeignMapSpec map{read_foreign(reading, remap.table("foreign")), {}};
    map.make = maker_of("map", map, reading.registry.maps(), &Library::map, reading.errors);
    reading.scenario.remap.foreign = std::move(map);
  } else if (std::find(strategies.begin(), strategies.end(), StrategyKind::foreign) != strategies.end()) {
    reading.errors.add(
        remap.place("foreign"),
        "[run] strategies names \"foreign\", and [remap] does not say which map that is; write foreign = { name = "
        "\"mine\" } in [remap]");
  }
}

}  // namespace

void read_remap(ScenarioReading& reading) {
  if (!reading.sound("remap")) return;
  const Table remap = reading.section("remap");
  RemapSpec& spec = reading.scenario.remap;
  const Table estimate = remap.table("estimate");
  spec.estimate_weight = estimate.number("weight");
  spec.estimate_steps = estimate.text("steps") == "last" ? StepCount::last : StepCount::average;
  const Rate bandwidth = remap.rate("bandwidth");
  spec.bandwidth_Hz = static_cast<double>(bandwidth.num) / static_cast<double>(bandwidth.den);
  spec.jump = remap.number("jump");
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
  read_rings(reading, remap);
  spec.predict_window = remap.span("predict_window", reading.scenario.nominal, reading.errors);
  if (remap.text("dropped") == "jump")
    spec.dropped_jump.reset();
  else
    spec.dropped_jump = remap.number("dropped_jump");
  if (remap.has("dropped_jump") && !spec.dropped_jump)
    reading.errors.add(remap.place("dropped_jump"),
                       "'dropped_jump' is about dropped = \"slew\"; remove it, or write dropped = \"slew\"");
  read_underrun(reading, remap.table("underrun"));
  read_filter(reading, remap.table("filter"));
  read_foreign_map(reading, remap);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& remap_fields() {
  static const std::vector<Field> rows{
      {.table = "remap", .key = "estimate", .forms = kTable,
       .meaning = "How the segment length is estimated (strategy `paper`)."},
      {.table = "remap", .key = "bandwidth", .forms = kRate, .default_toml = "\"2 Hz\"",
       .meaning = "How fast strategy `phase_locked` learns the pace: segments count less by e in about 1 / bandwidth. The "
                  "bandwidth of "
                  "`jack_dll`; the rate at which `lsl_dejitter` forgets.",
       .range = above(0, 1000)},
      {.table = "remap", .key = "jump", .forms = kNumber, .default_toml = "0.07",
       .meaning = "Strategy `phase_locked`: the most that the distance between slots changes per step, in steps. More "
                  "needs less latency; the hand jumps by it.",
       .range = between(0.01, 1)},
      {.table = "remap", .key = "latency", .forms = kWord | kSpan, .default_toml = "\"minimal\"",
       .meaning = "From reading the hand to emitting the force. `minimal`: the least without underrun for any device phase; "
                  "`minimal-this-phase`: for the phase of this run; `adaptive`: as `adapt` says, step by step.",
       .words = "minimal|minimal-this-phase|adaptive", .range = between(0, kLongestRun_s)},
      {.table = "remap", .key = "adapt", .forms = kTable,
       .meaning = "Limits of an adaptive latency, which grows at once when a force is late and shrinks slowly "
                  "(docs/choose/sizing.md)."},
      {.table = "remap", .key = "lead", .forms = kWord | kSpan, .default_toml = "\"minimal\"",
       .meaning =
           "How far before its slot a step reads the hand, or after it if negative; `minimal` as for `latency`, and it "
           "may be negative too.",
       .words = "minimal|minimal-this-phase", .range = between(-kLongestRun_s, kLongestRun_s)},
      {.table = "remap", .key = "rings", .forms = kInteger, .shape = Shape::list,
       .meaning = "Entries of the rings of samples and of forces, of strategies that map, as your program has them. What "
                  "has left a ring is an overrun. Default: what the timing needs.",
       .range = between(kLeastRing, kMostRing), .example = "[64, 32]"},
      {.table = "remap", .key = "dropped", .forms = kWord, .default_toml = "\"slew\"",
       .meaning = "What strategy `clocked` does where the loop dropped simulated time: `slew`: slots move by at most "
                  "`dropped_jump` per step until they are there. `jump`: at once.",
       .words = "slew|jump"},
      {.table = "remap", .key = "dropped_jump", .forms = kNumber, .default_toml = "0.07",
       .meaning = "In step sizes.",
       .range = between(0.001, 0.9)},
      {.table = "remap", .key = "underrun", .forms = kTable, .meaning = "What is used when data is missing."},
      {.table = "remap", .key = "predict_window", .forms = kSpan, .default_toml = "\"8 ms\"",
       .meaning = "Strategy `predict` takes the hand's velocity from this much of the past.",
       .range = above(0, 1)},
      {.table = "remap", .key = "filter", .forms = kTable,
       .meaning = "The filter of strategy `filtered`, which is `direct` with a filter added."},
      {.table = "remap.adapt", .key = "start", .forms = kSpan,
       .meaning = "What it starts with. Default: `min`.",
       .range = between(0, kLongestRun_s), .example = "\"20 ms\""},
      {.table = "remap.adapt", .key = "min", .forms = kSpan, .default_toml = "\"0 ms\"",
       .meaning = "The latency is never below this.",
       .range = between(0, kLongestRun_s)},
      {.table = "remap.adapt", .key = "max", .forms = kSpan, .default_toml = "\"100 ms\"",
       .meaning = "The latency is never above this: a step that needs more underruns. The rings are sized for it.",
       .range = between(0, kLongestRun_s)},
      {.table = "remap.adapt", .key = "window", .forms = kSpan, .default_toml = "\"10 s\"",
       .meaning = "The latency covers all that was needed within this time, to one part in 64.",
       .range = above(0, kLongestRun_s)},
      {.table = "remap.adapt", .key = "slew", .forms = kQuantity, .default_toml = "\"0.5 %\"",
       .meaning = "The most that the latency moves, as a share of the passing time, except for growing at once; in whole "
                  "millionths.",
       .dimension = D::ratio, .range = between(0, 0.5)},
      {.table = "remap.adapt", .key = "margin", .forms = kSpan, .default_toml = "\"1 ms\"",
       .meaning = "What it keeps above the largest need.",
       .range = between(0, 10)},
      {.table = "remap.estimate", .key = "kind", .forms = kWord, .default_toml = "\"ewma\"",
       .meaning = "Exponentially weighted moving average.",
       .words = "ewma"},
      {.table = "remap.estimate", .key = "weight", .forms = kNumber, .default_toml = "0.1",
       .meaning = "Weight of the newest segment.",
       .range = above(0, 1)},
      {.table = "remap.estimate", .key = "steps", .forms = kWord, .default_toml = "\"average\"",
       .meaning =
           "How many steps the next segment is taken to have: `average`, as the length is averaged, or as many as the "
           "`last` one.",
       .words = "average|last"},
      {.table = "remap.underrun", .key = "interaction", .forms = kWord, .default_toml = "\"clamp\"",
       .meaning = "`clamp`: the newest sample. `gate`: the step waits for its sample. `extrapolate`: the line through the "
                  "last 4 ms of samples, at most 10 ms on.",
       .words = "clamp|gate|extrapolate"},
      {.table = "remap.underrun", .key = "force", .forms = kWord, .default_toml = "\"hold\"",
       .meaning = "`hold`: the last force. `extrapolate`: the line through the last two, at most 10 ms on; needs `linear` "
                  "emission.",
       .words = "hold|extrapolate"},
      {.table = "remap.filter", .key = "kind", .forms = kWord, .default_toml = "\"butterworth\"",
       .meaning = "`butterworth`: second order low-pass. `one-euro`: a first order low-pass whose cutoff rises with speed.",
       .words = "moving-average|butterworth|one-euro"},
      {.table = "remap.filter", .key = "on", .forms = kWord, .default_toml = "\"force\"",
       .meaning = "`interaction`: filters what the steps read. `force`: filters what the device's ticks play.",
       .words = "interaction|force"},
      {.table = "remap.filter", .key = "window", .forms = kSpan, .default_toml = "\"1 segment\"",
       .meaning = "What is averaged.",
       .kinds = "moving-average", .range = above(0, kLongestRun_s)},
      {.table = "remap.filter", .key = "cutoff", .forms = kRate, .default_toml = "\"10 Hz\"",
       .meaning = "Where it is down by 3 dB.",
       .kinds = "butterworth", .range = above(0, 100'000)},
      {.table = "remap.filter", .key = "min_cutoff", .forms = kRate, .default_toml = "\"1 Hz\"",
       .meaning = "Cutoff at rest.",
       .kinds = "one-euro", .range = above(0, 100'000)},
      {.table = "remap.filter", .key = "beta", .forms = kNumber, .default_toml = "1.0",
       .meaning = "Hz more of cutoff per m/s (interaction) or N/s (force).",
       .kinds = "one-euro", .range = at_least(0)},
      {.table = "remap.filter", .key = "derivative_cutoff", .forms = kRate, .default_toml = "\"1 Hz\"",
       .meaning = "Cutoff of the low-pass filter on the speed.",
       .kinds = "one-euro", .range = above(0, 100'000)},
      {.table = "remap", .key = "foreign", .forms = kTable,
       .meaning = "The map of strategy `foreign`: one that is not evenstep's own."},
  };
  static const std::vector<Field> all = joined(joined(rows, library_rows("remap", "")), foreign_rows("remap.foreign", ""));
  return all;
}
// clang-format on

}  // namespace evenstep::internal
