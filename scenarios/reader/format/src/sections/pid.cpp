// [[device]] driver = "pid"
#include "effects.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep {
using namespace internal;

namespace {

std::optional<BoardKind> board_named(const std::string& name) {
  for (const NamedBoard& board : simulated_boards()) {
    if (board.name == name) return board.kind;
  }
  return std::nullopt;
}

}  // namespace

PidSpec PidSpec::read(const ScenarioReading& reading, const Table& device) {
  PidSpec spec;
  const Table pid = device.table("pid");
  read_effects(pid, device, spec, reading.errors);
  spec.flavour = pid.text("flavour") == "array" ? PidFlavour::array : PidFlavour::mask;
  spec.board = board_named(pid.text("firmware"));
  spec.pool_effects = static_cast<int>(pid.integer("pool"));
  if (pid.has("block_load_error")) spec.block_load_error_at = static_cast<int>(pid.integer("block_load_error")) - 1;
  for (const Table& event : device.tables("events")) {
    const auto kind =
        event.text("kind") == "safety-switch" ? PidDeviceEvent::Kind::safety_switch : PidDeviceEvent::Kind::actuator_power;
    const RealTime at{event.span("at", reading.scenario.nominal, reading.errors).ns};
    if (!spec.events.empty() && at < spec.events.back().at)
      reading.errors.add(event.place("at"), "'at': earlier than the event before; write them in order of time");
    spec.events.push_back({kind, at, event.boolean("on")});
  }
  return spec;
}

// A key is a few full lines.
// clang-format off
std::vector<Field> PidSpec::fields() {
  const std::vector<Field> device{
      driver_table_row("pid", "What the device does not say of itself."),
      {.table = "device", .key = "events", .forms = kTable, .shape = Shape::list,
       .meaning = "What somebody does to the simulated device.",
       .kinds = "pid"},
  };
  const std::vector<Field> own{
      {.table = "device.pid", .key = "flavour", .forms = kWord, .default_toml = "\"mask\"",
       .meaning = "Which report descriptor the simulated device has (docs/devices/hid.md).",
       .words = "mask|array"},
      {.table = "device.pid", .key = "firmware", .forms = kWord, .default_toml = "\"own\"",
       .meaning = "Whose firmware the simulated device has: `own` with its flavour, or that of a real board "
                  "(docs/devices/hid.md).",
       .words = "own|openffboard-1|openffboard-2|arduino|silent-pool|short-replies|vrs|asetek|moza|pxn|fixed-direction|"
                "two-commands|late-load|no-duration|load-error-first|load-never|load-always-1"},
      {.table = "device.pid", .key = "pool", .forms = kInteger, .default_toml = "40",
       .meaning = "Effects that the simulated device has room for; each used axis takes one.",
       .range = between(0, 40)},
      {.table = "device.pid", .key = "block_load_error", .forms = kInteger,
       .meaning = "Number of the request for an effect, counted from 1, that the simulated device answers with an error. "
                  "Default: none.",
       .range = between(1, 40), .example = "2"},
      {.table = "device.events", .key = "kind", .forms = kWord,
       .meaning = "The switch that is turned.",
       .words = "safety-switch|actuator-power", .required = true, .example = "\"safety-switch\""},
      {.table = "device.events", .key = "at", .forms = kSpan,
       .meaning = "In order of time.",
       .required = true, .range = between(0, kLongestRun_s), .example = "\"1 s\""},
      {.table = "device.events", .key = "on", .forms = kBoolean,
       .meaning = "false: no force any more.",
       .required = true, .example = "false"},
  };
  return joined(
      device,
      joined(
          effect_rows(
              {.table = "device.pid", .wheel_table = "device.pid.wheel",
               .travel = "From one end of each axis to the other, its middle at 0; 0: the axis is not used. "
                         "Obligatory without `wheel`.",
               .full_scale =
                   "Its force at the largest magnitude, measured or from its data sheet: PID knows no newtons. Without it "
                   "the device "
                   "is only read, and no expectation may be about its force.",
               .reversed_force =
                   "Axes along which the device pushes opposite to what Linux and DirectInput mean; measure it.",
               .axes = "x|y|z", .signed_axes = "x|y|z|-x|-y|-z", .longest_effect_s = 60,
               .effect_duration = "Time after its last start at which an effect ends by itself; it is started again after "
                                  "half of that time. `none`: never, for devices that cannot do so; if this program hangs, "
                                  "the last force stays.",
               .endless = "none"}),
          own));
}
// clang-format on

}  // namespace evenstep
