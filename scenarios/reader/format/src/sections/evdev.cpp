// [[device]] driver = "evdev"
#include "effects.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep {
using namespace internal;

EvdevSpec EvdevSpec::read(const ScenarioReading& reading, const Table& device) {
  EvdevSpec spec;
  const Table evdev = device.table("evdev");
  read_effects(evdev, device, spec, reading.errors);
  spec.options.update_rate = evdev.rate("update_rate");
  spec.options.still = evdev.duration("still");
  if (evdev.has("report_interval")) spec.report_interval = evdev.duration("report_interval");
  spec.effects = static_cast<int>(evdev.integer("effects"));
  spec.foreign_effects = static_cast<int>(evdev.integer("foreign_effects"));
  spec.held = evdev.boolean("held");
  if (evdev.has("meddled_at")) spec.meddled_at = RealTime{evdev.duration("meddled_at").ns};
  refuse_queue(device, "driver = \"evdev\" reads events, whose buffer is the kernel's (64 of them)", reading.errors);
  return spec;
}

// A key is a few full lines.
// clang-format off
std::vector<Field> EvdevSpec::fields() {
  const std::vector<Field> device{
      driver_table_row("evdev", "What Linux does not say of the device (docs/devices/evdev.md).")};
  const std::vector<Field> own{
      update_rate_row("device.evdev", "\"1 kHz\"",
                      "The most reports per second that the device takes; changed forces take turns. Any more would wait in "
                      "a queue of the kernel.",
                      100'000),
      {.table = "device.evdev", .key = "still", .forms = kDuration, .default_toml = "\"1 s\"",
       .meaning = "For how long a hand without events holds still: Linux tells changes only. After that it counts as not "
                  "reported.",
       .range = between(0, 60)},
      {.table = "device.evdev", .key = "report_interval", .forms = kDuration,
       .meaning = "The longest time between two reports of a hand that moves. Where samples say when they were taken, a "
                  "position that nothing has changed is as old as this (docs/devices/ages.md). Default: two periods of "
                  "`rate`.",
       .range = between(1e-5, 1), .example = "\"16 ms\""},
      {.table = "device.evdev", .key = "effects", .forms = kInteger, .default_toml = "16",
       .meaning = "Effects that the simulated device has room for, of all programs together; each used axis takes one.",
       .range = between(0, 96)},
      {.table = "device.evdev", .key = "foreign_effects", .forms = kInteger, .default_toml = "0",
       .meaning = "How many of these another program has taken.",
       .range = between(0, 96)},
      {.table = "device.evdev", .key = "held", .forms = kBoolean, .default_toml = "false",
       .meaning = "Another program has the simulated device for itself."},
      {.table = "device.evdev", .key = "meddled_at", .forms = kDuration,
       .meaning = "When another program stops all effects of the simulated device, turns its gain to 0 and has it center by "
                  "itself. Default: never.",
       .range = between(0, kLongestRun_s), .example = "\"2 s\""},
  };
  return joined(
      device,
      joined(
          effect_rows(
              {.table = "device.evdev", .wheel_table = "device.evdev.wheel",
               .travel =
                   "From one end of each axis (ABS_X, ABS_Y, ABS_Z) to the other, its middle at 0; 0: the axis is not used. "
                   "Obligatory without `wheel`. Forces are along X and Y.",
               .full_scale = "Its force at the largest level, measured or from its data sheet. Without it the device is "
                             "only read, and "
                             "no expectation may be about its force.",
               .reversed_force = "Axes along which the device pushes opposite to what Linux means; measure it.",
               .axes = "x|y", .signed_axes = "x|y|-x|-y", .longest_effect_s = 32}),
          own));
}
// clang-format on

}  // namespace evenstep
