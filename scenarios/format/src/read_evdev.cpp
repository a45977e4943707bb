// [[device]] driver = "evdev"
#include "field_rows.h"
#include "read_signs.h"
#include "sections.h"

namespace evenstep {
using namespace internal;

EvdevSpec EvdevSpec::read(const ScenarioReading& reading, const Table& device) {
  EvdevSpec spec;
  const Table evdev = device.table("evdev");
  spec.options.travel_m = evdev.vector("travel");
  if (spec.options.travel_m == glm::dvec3(0))
    reading.errors.add(evdev.place("travel"),
                       "'travel': no axis is used; write the travel of one, [\"200 mm\", \"0 mm\", \"0 mm\"]");
  if (evdev.has("full_scale")) spec.options.full_scale_N = evdev.si("full_scale");
  if (evdev.has("full_slope")) spec.options.full_slope_N_per_m = glm::dvec3(evdev.si("full_slope"));
  spec.options.gain = evdev.number("gain");
  spec.options.springs = device.table("render").text("kind") == "device_spring";
  read_signs(evdev, spec.options, reading.errors);
  spec.options.effect_duration = evdev.duration("effect_duration");
  spec.options.update_rate = evdev.rate("update_rate");
  spec.options.still = evdev.duration("still");
  spec.firmware_rate = evdev.rate("firmware_rate");
  spec.effects = static_cast<int>(evdev.integer("effects"));
  spec.foreign_effects = static_cast<int>(evdev.integer("foreign_effects"));
  spec.held = evdev.boolean("held");
  if (evdev.has("meddled_at")) spec.meddled_at = RealTime{evdev.duration("meddled_at").ns};
  if (device.has("queue"))
    reading.errors.add(device.place("queue"),
                       "'queue' is about reports on a hidraw or libusb handle, and driver = \"evdev\" reads events, whose "
                       "buffer is the kernel's (64 of them); remove it");
  return spec;
}

// clang-format off: a row reads as a row
std::vector<Field> EvdevSpec::fields() {
  return {
      {.table = "device",
       .key = "evdev",
       .forms = kTable,
       .meaning = "What Linux does not say of the device (docs/evdev.md).",
       .kinds = "evdev",
       .required = true},
      {.table = "device.evdev",
       .key = "travel",
       .forms = kQuantity,
       .shape = Shape::three,
       .meaning = "From one end of each axis (ABS_X, ABS_Y, ABS_Z) to the other, its middle at 0; 0: the axis is not used. "
                  "Forces are along X and Y.",
       .required = true,
       .dimension = D::length,
       .range = between(0, 2),
       .example = "[\"200 mm\", \"200 mm\", \"0 mm\"]"},
      {.table = "device.evdev",
       .key = "full_scale",
       .forms = kQuantity,
       .meaning = "Its force at the largest level, measured or from its data sheet. Without it the device is only read, and "
                  "no expectation may be about its force.",
       .dimension = D::force,
       .range = above(0),
       .example = "\"5 N\""},
      {.table = "device.evdev",
       .key = "full_slope",
       .forms = kQuantity,
       .meaning =
           "What a spring with its largest coefficient is at full gain. Default: the full scale over half the travel; "
           "measure it.",
       .dimension = D::stiffness,
       .range = above(0),
       .example = "\"500 N/m\""},
      {.table = "device.evdev",
       .key = "firmware_rate",
       .forms = kRate,
       .default_toml = "\"4 kHz\"",
       .meaning = "How often the device renders its own springs: the simulated one does, of a real one the laws of "
                  "stiffness believe it.",
       .range = between(100, 100'000)},
      {.table = "device.evdev",
       .key = "gain",
       .forms = kNumber,
       .default_toml = "0.25",
       .meaning = "The share of its full scale that may be used: its largest force.",
       .range = above(0, 1)},
      {.table = "device.evdev",
       .key = "reversed_force",
       .forms = kWord,
       .shape = Shape::list,
       .default_toml = "[]",
       .meaning = "Axes along which the device pushes the other way than Linux means it; measure it.",
       .words = "x|y"},
      {.table = "device.evdev",
       .key = "springs",
       .forms = kWord,
       .shape = Shape::list,
       .default_toml = "[]",
       .meaning = "Axes along which the device may render springs by itself because the sign was measured; `-y`: a positive "
                  "coefficient pushes away from the center. Without it only `x`, and not if its force is reversed.",
       .words = "x|y|-x|-y"},
      {.table = "device.evdev",
       .key = "effect_duration",
       .forms = kDuration,
       .default_toml = "\"0.5 s\"",
       .meaning =
           "Time after its last start at which an effect ends by itself; it is started again after half of that time.",
       .range = between(0.01, 32)},
      {.table = "device.evdev",
       .key = "update_rate",
       .forms = kRate,
       .default_toml = "\"1 kHz\"",
       .meaning =
           "How many reports a second the device takes at most; changed forces take turns. More would wait in a queue "
           "of the kernel's.",
       .range = between(1, 100'000)},
      {.table = "device.evdev",
       .key = "still",
       .forms = kDuration,
       .default_toml = "\"1 s\"",
       .meaning = "For how long a hand without events holds still: Linux tells changes only. After that it counts as not "
                  "reported.",
       .range = between(0, 60)},
      {.table = "device.evdev",
       .key = "effects",
       .forms = kInteger,
       .default_toml = "16",
       .meaning = "Effects that the simulated device has room for, of all programs together; each used axis takes one.",
       .range = between(0, 96)},
      {.table = "device.evdev",
       .key = "foreign_effects",
       .forms = kInteger,
       .default_toml = "0",
       .meaning = "How many of these another program has taken.",
       .range = between(0, 96)},
      {.table = "device.evdev",
       .key = "held",
       .forms = kBoolean,
       .default_toml = "false",
       .meaning = "Another program has the simulated device for itself."},
      {.table = "device.evdev",
       .key = "meddled_at",
       .forms = kDuration,
       .meaning = "When another program stops all effects of the simulated device, turns its gain to 0 and has it center by "
                  "itself. Default: never.",
       .range = between(0, kLongestRun_s),
       .example = "\"2 s\""},
  };
}
// clang-format on

}  // namespace evenstep
