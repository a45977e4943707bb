#include "evenstep/format/scenario.h"

#include <algorithm>
#include <cmath>

namespace evenstep {

const StrategyTraits& traits_of(StrategyKind kind) {
  return *std::find_if(kAllStrategies.begin(), kAllStrategies.end(),
                       [&](const StrategyTraits& traits) { return traits.kind == kind; });
}

const StrategyTraits* strategy_named(std::string_view name) {
  const auto found = std::find_if(kAllStrategies.begin(), kAllStrategies.end(),
                                  [&](const StrategyTraits& traits) { return traits.name == name; });
  return found == kAllStrategies.end() ? nullptr : &*found;
}

const char* name_of(InteractionUnderrun policy) {
  switch (policy) {
    case InteractionUnderrun::clamp:
      return "clamp";
    case InteractionUnderrun::gate:
      return "gate";
    case InteractionUnderrun::extrapolate:
      return "extrapolate";
  }
  return "";
}

const char* name_of(ForceUnderrun policy) { return policy == ForceUnderrun::hold ? "hold" : "extrapolate"; }

ForceLimits force_limits(const GuardSpec& spec, const ForceLimits& otherwise) {
  const CutLimits& cut = otherwise.cut;
  return {.max_N = spec.max_N.value_or(otherwise.max_N),
          .max_slew_N_per_s = spec.max_slew_N_per_s.value_or(otherwise.max_slew_N_per_s),
          .cut = {.gain = spec.gain.value_or(cut.gain),
                  .ramp_up = spec.ramp_up.value_or(cut.ramp_up),
                  .ramp_down = spec.ramp_down.value_or(cut.ramp_down),
                  .max_speed_m_per_s = spec.max_speed_m_per_s.value_or(cut.max_speed_m_per_s),
                  .stale_force = spec.stale_force.value_or(cut.stale_force),
                  .stale_hand = spec.stale_hand.value_or(cut.stale_hand)}};
}

std::vector<const Expectation*> conditions_of(const Scenario& scenario) {
  std::vector<const Expectation*> all;
  for (const Expectation& expectation : scenario.expectations) all.push_back(&expectation);
  for (const Sometimes& state : scenario.sometimes) all.push_back(&state.condition);
  return all;
}

bool has_hand(const Scenario& scenario) {
  return std::any_of(scenario.devices.begin(), scenario.devices.end(),
                     [](const DeviceSpec& device) { return device.hand.has_value(); });
}

bool says_when_taken(const DriverSpec& driver) {
  return std::holds_alternative<ReferenceSpec>(driver) || std::holds_alternative<EvdevSpec>(driver);
}

bool follows_clock(const DeviceSpec& device) {
  if (!says_when_taken(device.driver)) return false;
  return device.age.follows_clock.value_or(device.is_real || device.age.is_given());
}

std::optional<Duration> unchanged_age_of(const DeviceSpec& device) {
  const auto* evdev = std::get_if<EvdevSpec>(&device.driver);
  if (!evdev || !follows_clock(device)) return std::nullopt;
  return evdev->report_interval.value_or(period_ceil(device.rate) * 2) + device.age.least + device.age.jitter;
}

Duration largest_age(const DeviceSpec& device) {
  if (!follows_clock(device)) return {};
  constexpr Duration kStamp{999};  // time stamps are whole microseconds
  const auto& [least, jitter, clock_ppm, seed, follows] = device.age;
  const Duration period = period_ceil(device.rate);
  const std::optional<Duration> unchanged = unchanged_age_of(device);
  if (device.is_real || clock_ppm != 0) {
    // From report to report, by the host's clock.
    const std::int64_t scale = 1'000'000 + clock_ppm;
    const Duration reports{(period.ns * 1'000'000 + scale - 1) / scale};
    // The clock of a slower device is followed from below: until it has slipped by a period, a sample seems to be up to a
    // period older (docs/devices/ages.md). Linux has stamped events by the host's clock.
    const bool from_below = clock_ppm < 0 && !std::holds_alternative<EvdevSpec>(device.driver);
    const Duration behind = from_below ? reports : Duration{};
    return std::max(unchanged.value_or(Duration{}),
                    least + jitter + std::max(reports, period) - Duration{1} + behind + kStamp);
  }
  // Device and host have one clock: a report always waits for the same tick or, if it is older, for one of the next.
  const auto ticks = [&](Duration age) { return first_tick_at_or_after(device.rate, RealTime{age.ns}); };
  if (unchanged) return std::max(*unchanged, period * ticks(least + jitter) + kStamp);
  return least + period * (ticks(least + jitter) - ticks(least)) + kStamp;
}

FilterSpec filter_at(const RemapSpec& remap, Rate rate) {
  if (!std::holds_alternative<MovingAverageSpec>(remap.filter)) return remap.filter;
  const double samples = seconds(remap.filter_window) * static_cast<double>(rate.num) / static_cast<double>(rate.den);
  return MovingAverageSpec{static_cast<int>(std::clamp(std::round(samples), 1.0, kMaxAveragedSamples + 1.0))};
}

std::optional<SpringMode> smith_mode(const Scene& scene, const SmithRender& render) {
  TissueMode mode = render.mode;
  if (const auto* tissue = std::get_if<ModeScene>(&scene.body)) {
    if (!mode.frequency_Hz) mode.frequency_Hz = tissue->frequency_Hz;
    if (!mode.damping_ratio) mode.damping_ratio = tissue->damping_ratio;
    if (!mode.static_N_per_m) mode.static_N_per_m = tissue->stiffness_N_per_m;
  }
  if (!mode.frequency_Hz || !mode.damping_ratio || !mode.static_N_per_m) return std::nullopt;
  constexpr double kPi = 3.14159265358979323846;
  const double turn_per_s = 2 * kPi * *mode.frequency_Hz, spring_N_per_m = 2 * *mode.static_N_per_m;
  // The mass is that of the tissue, whatever the factor is.
  const double mass_kg = 2 * spring_N_per_m / (turn_per_s * turn_per_s);
  return SpringMode{.contact_N_per_m = spring_N_per_m * render.factor,
                    .ground_N_per_m = spring_N_per_m * render.factor,
                    .mass_kg = mass_kg,
                    .damping_N_s_per_m = 2 * *mode.damping_ratio * mass_kg * turn_per_s};
}

}  // namespace evenstep
