// [[device]] driver = "inverse3"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep {
using namespace internal;

Inverse3Spec Inverse3Spec::read(const ScenarioReading& reading, const Table& device) {
  Inverse3Spec spec;
  const Table inverse3 = device.table("inverse3");
  spec.options.origin_m = inverse3.vector("origin");
  spec.options.shared = inverse3.boolean("shared");
  spec.update_rate = inverse3.rate("update_rate");
  spec.hold = inverse3.duration("hold");
  spec.remote = inverse3.boolean("remote");
  spec.in_use = inverse3.boolean("in_use");
  if (inverse3.has("uncalibrated_at")) spec.uncalibrated_at = RealTime{inverse3.duration("uncalibrated_at").ns};
  refuse_queue(device, "driver = \"inverse3\" keeps the newest message alone", reading.errors);
  return spec;
}

// A key is a few full lines.
// clang-format off
std::vector<Field> Inverse3Spec::fields() {
  return {
      driver_table_row("inverse3",
                       "Where position 0 is, and what else the service does not say (docs/devices/inverse3.md)."),
      {.table = "device.inverse3", .key = "origin", .forms = kQuantity, .shape = Shape::three,
       .meaning = "The position that the service reports at the place that is to be position 0.",
       .required = true, .dimension = D::length, .range = between(-1, 1), .example = "[\"0 mm\", \"-120 mm\", \"150 mm\"]"},
      {.table = "device.inverse3", .key = "shared", .forms = kBoolean, .default_toml = "false",
       .meaning = "Use the device even if the service says that another program does."},
      update_rate_row("device.inverse3", "\"2 kHz\"",
                      "The most times per second that a real service is sent a force and asked for a position.", 10'000),
      {.table = "device.inverse3", .key = "hold", .forms = kDuration, .default_toml = "\"0.1 s\"",
       .meaning = "A force that no newer one has replaced for so long, because the program hangs, is followed by zero.",
       .range = between(0.001, 10)},
      {.table = "device.inverse3", .key = "remote", .forms = kBoolean, .default_toml = "false",
       .meaning = "Allow a service on another machine. Whoever is on the network between can then move the hand."},
      {.table = "device.inverse3", .key = "in_use", .forms = kBoolean, .default_toml = "false",
       .meaning = "The simulated service says that another program uses the device."},
      {.table = "device.inverse3", .key = "uncalibrated_at", .forms = kDuration,
       .meaning = "From then on the simulated service says that the device is not calibrated, and a position that means "
                  "nothing. Default: never.",
       .range = between(0, kLongestRun_s), .example = "\"2 s\""},
  };
}
// clang-format on

}  // namespace evenstep
