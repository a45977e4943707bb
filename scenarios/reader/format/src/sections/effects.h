#pragma once
/// What a scenario says of a device that plays effects, whichever driver plays them: driver = "pid" and "evdev".

#include <fmt/format.h>

#include <cstddef>
#include <string_view>
#include <type_traits>
#include <vector>

#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {

inline std::size_t axis_of(char letter) { return static_cast<std::size_t>(letter - 'x'); }

template <class Options>
void read_signs(const Table& table, Options& options, Errors& errors) {
  for (const Value& axis : table.at("reversed_force").list) options.reversed_force[axis_of(axis.text[0])] = true;
  for (const Value& axis : table.at("springs").list) {
    const bool reversed = axis.text[0] == '-';
    auto& known = options.reversed_spring[axis_of(axis.text.back())];
    if (known && *known != reversed)
      errors.add(axis.place,
                 fmt::format("'springs' names both signs of {}; write the one that was measured", axis.text.back()));
    known = reversed;
  }
}

/// A wheel's turn and torque, as the travel and the force of the hand at its rim.
template <class Spec>
void read_reach(const Table& table, Spec& spec, Errors& errors) {
  if (!table.has("wheel")) {
    if (table.has("full_scale")) spec.options.full_scale_N = table.si("full_scale");
    if (table.has("travel")) spec.options.travel_m = table.vector("travel");
    if (spec.options.travel_m == glm::dvec3(0))
      errors.add(table.place("travel"),
                 "'travel': no axis is used; write the travel of one, [\"200 mm\", \"0 mm\", \"0 mm\"], or the turn and the "
                 "radius of a wheel, wheel = { turn = \"900 deg\", radius = \"140 mm\" }");
    return;
  }
  constexpr double kRadians = 3.14159265358979323846 / 180;
  for (const char* key : {"travel", "full_scale"}) {
    if (table.has(key)) errors.add(table.place(key), fmt::format("'{}' follows from 'wheel'; remove one of them", key));
  }
  const Table wheel = table.table("wheel");
  const double radius_m = wheel.si("radius");
  spec.options.travel_m = {wheel.si("turn") * kRadians * radius_m, 0, 0};
  if (wheel.has("torque")) spec.options.full_scale_N = wheel.si("torque") / radius_m;
}

/// The keys of effect_rows().
template <class Spec>
void read_effects(const Table& table, const Table& device, Spec& spec, Errors& errors) {
  read_reach(table, spec, errors);
  if (table.has("full_slope")) spec.options.full_slope_N_per_m = glm::dvec3(table.si("full_slope"));
  spec.options.gain = table.number("gain");
  spec.options.springs = device.table("render").text("kind") == "device_spring";
  read_signs(table, spec.options, errors);
  if (spec.options.springs && spec.options.full_scale_N && table.at("springs").list.empty()) {
    errors.add(
        device.table("render").place("kind"),
        "'render': the device has no spring whose sign is known; measure it (docs/devices/hid.md) and write springs = "
        "[\"x\"] beside its travel, or let this program render: kind = \"local\"");
  }
  if constexpr (std::is_same_v<Spec, PidSpec>) {
    if (table.text("effect_duration") == "none") spec.options.effect_duration.reset();
  }
  if (table.text("effect_duration") != "none") spec.options.effect_duration = table.duration("effect_duration");
  spec.firmware_rate = table.rate("firmware_rate");
}

/// What is not the same for both.
struct EffectTexts {
  std::string_view table, wheel_table;
  std::string_view travel, full_scale, reversed_force;  // meanings
  std::string_view axes, signed_axes;                   // words
  double longest_effect_s = 0;
  std::string_view effect_duration =  // meaning
      "Time after its last start at which an effect ends by itself; it is started again after half of that time.";
  std::string_view endless;  // a word in place of the duration
};

// clang-format off: a row reads as a row
inline std::vector<Field> effect_rows(const EffectTexts& texts) {
  return {
      {.table = texts.table,
       .key = "travel",
       .forms = kQuantity,
       .shape = Shape::three,
       .meaning = texts.travel,
       .dimension = D::length,
       .range = between(0, 2),
       .example = "[\"200 mm\", \"200 mm\", \"0 mm\"]"},
      {.table = texts.table,
       .key = "full_scale",
       .forms = kQuantity,
       .meaning = texts.full_scale,
       .dimension = D::force,
       .range = above(0),
       .example = "\"5 N\""},
      {.table = texts.table,
       .key = "wheel",
       .forms = kTable,
       .meaning =
           "In place of `travel` and `full_scale`: an axis X that turns. Positions are lengths along the rim, 0 in the "
           "middle, and forces those of a hand there."},
      {.table = texts.wheel_table,
       .key = "turn",
       .forms = kQuantity,
       .meaning = "From one end to the other.",
       .required = true,
       .dimension = D::angle,
       .range = above(0, 7200)},
      {.table = texts.wheel_table,
       .key = "radius",
       .forms = kQuantity,
       .meaning = "Of the rim that the hand holds.",
       .required = true,
       .dimension = D::length,
       .range = above(0, 1),
       .example = "\"140 mm\""},
      {.table = texts.wheel_table,
       .key = "torque",
       .forms = kQuantity,
       .meaning = "At the largest magnitude, measured or from the data sheet; as `full_scale`.",
       .dimension = D::torque,
       .range = above(0)},
      {.table = texts.table,
       .key = "full_slope",
       .forms = kQuantity,
       .meaning = "What a spring with its largest coefficient is at full gain. Default: the full scale over half the "
                  "travel, which is what "
                  "most firmware makes of it; measure it.",
       .dimension = D::stiffness,
       .range = above(0),
       .example = "\"500 N/m\""},
      {.table = texts.table,
       .key = "firmware_rate",
       .forms = kRate,
       .default_toml = "\"4 kHz\"",
       .meaning = "How often the device renders its own springs. The simulated device does so; of a real one the laws of "
                  "stiffness assume it.",
       .range = between(100, 100'000)},
      {.table = texts.table,
       .key = "gain",
       .forms = kNumber,
       .default_toml = "0.25",
       .meaning = "The share of its full scale that may be used: its largest force.",
       .range = above(0, 1)},
      {.table = texts.table,
       .key = "reversed_force",
       .forms = kWord,
       .shape = Shape::list,
       .default_toml = "[]",
       .meaning = texts.reversed_force,
       .words = texts.axes},
      {.table = texts.table,
       .key = "springs",
       .forms = kWord,
       .shape = Shape::list,
       .default_toml = "[]",
       .meaning = "Axes along which the device may render springs by itself because the sign was measured; `-y`: a positive "
                  "coefficient pushes away from the center. Along the others the program renders them.",
       .words = texts.signed_axes},
      {.table = texts.table,
       .key = "effect_duration",
       .forms = texts.endless.empty() ? kDuration : kDuration | kWord,
       .default_toml = "\"0.5 s\"",
       .meaning = texts.effect_duration,
       .words = texts.endless,
       .range = between(0.01, texts.longest_effect_s)},
  };
}
// clang-format on

}  // namespace evenstep::internal
