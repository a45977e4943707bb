// [[device]] driver = "pid"
#include "field_rows.h"
#include "read_signs.h"
#include "sections.h"

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
  spec.options.travel_m = pid.vector("travel");
  if (spec.options.travel_m == glm::dvec3(0))
    reading.errors.add(pid.place("travel"),
                       "'travel': no axis is used; write the travel of one, [\"200 mm\", \"0 mm\", \"0 mm\"]");
  if (pid.has("full_scale")) spec.options.full_scale_N = pid.si("full_scale");
  if (pid.has("full_slope")) spec.options.full_slope_N_per_m = glm::dvec3(pid.si("full_slope"));
  spec.options.springs = device.table("render").text("kind") == "device_spring";
  spec.firmware_rate = pid.rate("firmware_rate");
  spec.options.gain = pid.number("gain");
  read_signs(pid, spec.options, reading.errors);
  spec.options.effect_duration = pid.duration("effect_duration");
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

// clang-format off: a row reads as a row
std::vector<Field> PidSpec::fields() {
  return {
      {.table = "device",
       .key = "pid",
       .forms = kTable,
       .meaning = "What the device does not say of itself.",
       .kinds = "pid",
       .required = true},
      {.table = "device",
       .key = "events",
       .forms = kTable,
       .shape = Shape::list,
       .meaning = "What somebody does to the simulated device.",
       .kinds = "pid"},
      {.table = "device.pid",
       .key = "travel",
       .forms = kQuantity,
       .shape = Shape::three,
       .meaning = "From one end of each axis to the other, its middle at 0; 0: the axis is not used.",
       .required = true,
       .dimension = D::length,
       .range = between(0, 2),
       .example = "[\"200 mm\", \"200 mm\", \"0 mm\"]"},
      {.table = "device.pid",
       .key = "full_scale",
       .forms = kQuantity,
       .meaning = "Its force at the largest magnitude, measured or from its data sheet: PID knows no newtons. Without it "
                  "the device "
                  "is only read, and no expectation may be about its force.",
       .dimension = D::force,
       .range = above(0),
       .example = "\"5 N\""},
      {.table = "device.pid",
       .key = "full_slope",
       .forms = kQuantity,
       .meaning = "What a spring with its largest coefficient is at full gain. Default: the full scale over half the "
                  "travel, which is what "
                  "most firmware makes of it; measure it.",
       .dimension = D::stiffness,
       .range = above(0),
       .example = "\"500 N/m\""},
      {.table = "device.pid",
       .key = "firmware_rate",
       .forms = kRate,
       .default_toml = "\"4 kHz\"",
       .meaning = "How often the device renders its own springs: the simulated one does, of a real one the laws of "
                  "stiffness believe it.",
       .range = between(100, 100'000)},
      {.table = "device.pid",
       .key = "gain",
       .forms = kNumber,
       .default_toml = "0.25",
       .meaning = "The share of its full scale that may be used: its largest force.",
       .range = above(0, 1)},
      {.table = "device.pid",
       .key = "reversed_force",
       .forms = kWord,
       .shape = Shape::list,
       .default_toml = "[]",
       .meaning = "Axes along which the device pushes the other way than Linux and DirectInput mean it; measure it.",
       .words = "x|y|z"},
      {.table = "device.pid",
       .key = "springs",
       .forms = kWord,
       .shape = Shape::list,
       .default_toml = "[]",
       .meaning = "Axes along which the device may render springs by itself because the sign was measured; `-y`: a positive "
                  "coefficient pushes away from the center. Without it only `x`, and not if its force is reversed.",
       .words = "x|y|z|-x|-y|-z"},
      {.table = "device.pid",
       .key = "effect_duration",
       .forms = kDuration,
       .default_toml = "\"0.5 s\"",
       .meaning =
           "Time after its last start at which an effect ends by itself; it is started again after half of that time.",
       .range = between(0.01, 60)},
      {.table = "device.pid",
       .key = "flavour",
       .forms = kWord,
       .default_toml = "\"mask\"",
       .meaning = "Which report descriptor the simulated device has (docs/hid.md).",
       .words = "mask|array"},
      {.table = "device.pid",
       .key = "firmware",
       .forms = kWord,
       .default_toml = "\"own\"",
       .meaning = "Whose firmware the simulated device has: `own` with its flavour, or that of a real board (docs/hid.md).",
       .words = "own|openffboard-1|openffboard-2|arduino|silent-pool|short-replies"},
      {.table = "device.pid",
       .key = "pool",
       .forms = kInteger,
       .default_toml = "40",
       .meaning = "Effects that the simulated device has room for; each used axis takes one.",
       .range = between(0, 40)},
      {.table = "device.pid",
       .key = "block_load_error",
       .forms = kInteger,
       .meaning = "Number of the request for an effect, counted from 1, that the simulated device answers with an error. "
                  "Default: none.",
       .range = between(1, 40),
       .example = "2"},
      {.table = "device.events",
       .key = "kind",
       .forms = kWord,
       .meaning = "The switch that is turned.",
       .words = "safety-switch|actuator-power",
       .required = true,
       .example = "\"safety-switch\""},
      {.table = "device.events",
       .key = "at",
       .forms = kSpan,
       .meaning = "In order of time.",
       .required = true,
       .range = between(0, kLongestRun_s),
       .example = "\"1 s\""},
      {.table = "device.events",
       .key = "on",
       .forms = kBoolean,
       .meaning = "false: no force any more.",
       .required = true,
       .example = "false"},
  };
}
// clang-format on

}  // namespace evenstep
