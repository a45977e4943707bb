// [[device]]
#include <fmt/format.h>

#include <algorithm>

#include "src/drivers.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

bool proper_name(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

void check_name(const Table& device, const std::vector<DeviceSpec>& earlier, Errors& errors) {
  const std::string name = device.text("name");
  if (!proper_name(name)) {
    errors.add(device.place("name"),
               fmt::format("'name': \"{}\" must be letters, digits, _ and - (it is a part of signal names)", name));
  }
  for (const char* taken : {"run", "solver", "events", "closed_loop"}) {
    if (name == taken)
      errors.add(device.place("name"), fmt::format("'name': \"{}\" is a signal of its own; choose another name", name));
  }
  if (std::any_of(earlier.begin(), earlier.end(), [&](const DeviceSpec& d) { return d.name == name; })) {
    errors.add(device.place("name"), fmt::format("'name': there is a device \"{}\" already", name));
  }
}

LocalRender::Cap read_cap(const Table& render) {
  using Kind = LocalRender::Cap::Kind;
  if (render.text("cap") == "law") return {Kind::by_law, 0};
  return {Kind::fixed, render.si("cap")};
}

LocalRender read_local(const Table& render) {
  LocalRender local;
  local.by_device = render.text("kind") == "device_spring";
  local.alpha = render.at("alpha").is(Value::Kind::text) ? std::nullopt : std::optional(render.number("alpha"));
  local.stiffness = render.text("stiffness") == "settled" ? LocalModel::settled : LocalModel::instantaneous;
  local.knows_gap = render.boolean("gap");
  const std::string part = render.text("directions");
  if (part == "normal") local.part = StiffnessPart::normal;
  if (part == "axes") local.part = StiffnessPart::axes;
  local.coupled = render.boolean("coupled");
  if (render.has("cap")) local.cap = read_cap(render);
  return local;
}

SmithRender read_smith(const Table& render) {
  SmithRender smith;
  if (render.has("frequency")) smith.mode.frequency_Hz = in_Hz(render.rate("frequency"));
  if (render.has("damping_ratio")) smith.mode.damping_ratio = render.number("damping_ratio");
  if (render.has("static_stiffness")) smith.mode.static_N_per_m = render.si("static_stiffness");
  smith.factor = render.number("factor");
  return smith;
}

RenderSpec read_render(const Table& render) {
  const std::string kind = render.text("kind");
  if (kind == "local" || kind == "device_spring") return read_local(render);
  if (kind == "smith") return read_smith(render);
  return ForceRender{};
}

/// Refuses the reference twin for a hand: it reads the programmed motion, which a hand does not have.
void check_strategies(const ScenarioReading& reading) {
  const auto& strategies = reading.scenario.strategies;
  if (!has_hand(reading.scenario) || !reading.sound("run")) return;
  if (std::none_of(strategies.begin(), strategies.end(), [](StrategyKind kind) { return traits_of(kind).knows_motion; }))
    return;
  reading.errors.add(reading.section("run").place("strategies"),
                     "'strategies': \"ideal\" reads the programmed motion, and a hand that feels the force has none; write "
                     "strategies = [\"direct\", \"phase_locked\"]");
}

constexpr std::pair<std::string_view, ReportFault::Kind> kFaults[] = {
    {"lost", ReportFault::Kind::lost},
    {"duplicated", ReportFault::Kind::duplicated},
    {"late", ReportFault::Kind::late},
    {"cut", ReportFault::Kind::cut},
    {"longer", ReportFault::Kind::longer},
    {"unknown-id", ReportFault::Kind::unknown_id},
    {"interrupted", ReportFault::Kind::interrupted},
    {"unread", ReportFault::Kind::unread},
    {"write-lost", ReportFault::Kind::write_lost},
    {"write-rejected", ReportFault::Kind::write_rejected},
    {"write-refused", ReportFault::Kind::write_refused},
};

/// Reads faults, which are given by time in the file and by tick in the device. More ticks than a run of hours has are an
/// error in the file.
void read_faults(const ScenarioReading& reading, const Table& device, DeviceSpec& spec) {
  constexpr std::size_t kMostFaults = 1'000'000;
  for (const Table& fault : device.tables("faults")) {
    const auto kind = std::find_if(std::begin(kFaults), std::end(kFaults),
                                   [&](const auto& word) { return word.first == fault.text("kind"); });
    const RealTime at{fault.span("at", reading.scenario.nominal, reading.errors).ns};
    const std::int64_t first = first_tick_at_or_after(spec.rate, at, RealTime{spec.phase.ns});
    for (std::int64_t i = 0; i < fault.integer("ticks") && spec.faults.size() < kMostFaults; ++i)
      spec.faults.push_back({kind->second, first + i, fault.integer("amount")});
  }
  std::stable_sort(spec.faults.begin(), spec.faults.end(),
                   [](const ReportFault& a, const ReportFault& b) { return a.tick < b.tick; });
}

/// Checks that the device can render springs: it must have them, and its newtons must be known to give their stiffness.
void check_springs(const Table& render, const DeviceSpec& spec, Errors& errors) {
  const auto* local = std::get_if<LocalRender>(&spec.render);
  if (!local || !local->by_device) return;
  const std::optional<OwnSprings> springs = own_springs(spec.driver);
  if (springs && springs->steepest_N_per_m) return;
  errors.add(render.place("kind"),
             springs ? "'kind': \"device_spring\" needs to know what the device's springs are in N/m; write "
                       "full_scale in its 'pid' or 'evdev'"
                     : "'kind': \"device_spring\" is for devices that render springs by themselves; write "
                       "driver = \"pid\" or \"evdev\", or kind = \"local\", which sends the same as forces");
}

/// Ages, for a driver whose reports say when they were taken.
ReportAge read_age(const ScenarioReading& reading, const Table& device, const DriverSpec& driver) {
  ReportAge age;
  age.seed = reading.scenario.seed;
  if (device.has("report_age")) age.least = device.span("report_age", reading.scenario.nominal, reading.errors);
  if (device.has("report_age_jitter"))
    age.jitter = device.span("report_age_jitter", reading.scenario.nominal, reading.errors);
  if (device.has("clock_rate_error")) age.clock_ppm = device.whole_ppm("clock_rate_error", reading.errors);
  if (device.has("sample_time")) age.follows_clock = device.text("sample_time") == "taken";
  if (age.follows_clock.value_or(false) && !says_when_taken(driver))
    reading.errors.add(device.place("sample_time"),
                       "'sample_time': \"taken\" needs reports that say when they were taken, as those of driver = "
                       "\"reference\" and \"evdev\" do; write \"arrival\"");
  return age;
}

GuardSpec read_guard(const Table& device, const NominalUnits& nominal, Errors& errors) {
  GuardSpec spec;
  const Table guard = device.table("guard");
  const auto span = [&](std::string_view key) {
    return guard.has(key) ? std::optional(guard.span(key, nominal, errors)) : std::nullopt;
  };
  if (device.has("force_limit")) spec.max_N = device.si("force_limit");
  if (device.has("slew_limit")) spec.max_slew_N_per_s = device.si("slew_limit");
  if (guard.has("gain")) spec.gain = guard.number("gain");
  spec.ramp_up = span("ramp_up");
  spec.ramp_down = span("ramp_down");
  if (guard.has("speed_limit")) spec.max_speed_m_per_s = guard.si("speed_limit");
  spec.stale_force = span("stale_force");
  spec.stale_hand = span("stale_hand");
  return spec;
}

void read_return(ScenarioReading& reading, const Table& device, DeviceSpec& spec) {
  if (!device.has("returns")) return;
  spec.returns = device.span("returns", reading.scenario.nominal, reading.errors);
  const Place place = device.place("returns");
  if (const std::string why_not = why_no_return(spec.driver); !why_not.empty())
    reading.errors.add(place, "'returns': " + why_not);
  else if (!spec.unplug)
    reading.errors.add(place, "'returns': it was never unplugged; write when, in 'unplug', or remove it");
  else if (*spec.returns <= *spec.unplug)
    reading.errors.add(place, fmt::format("'returns': at {} it is not unplugged yet ({}); write a later time",
                                          in_ms(*spec.returns), in_ms(*spec.unplug)));
}

DeviceSpec read_device(ScenarioReading& reading, const Table& device) {
  DeviceSpec spec;
  spec.name = device.text("name");
  spec.rate = device.rate("rate");
  spec.phase = device.span("phase", reading.scenario.nominal, reading.errors);
  if (spec.phase >= period_ceil(spec.rate)) {
    reading.errors.add(device.place("phase"), fmt::format("'phase': {} is a period of {} or more; write the rest",
                                                          in_ms(spec.phase), in_ms(period_ceil(spec.rate))));
  }
  for (const DriverFormat& driver : driver_formats()) {
    if (driver.name == device.text("driver")) spec.driver = driver.read(reading, device);
  }
  spec.driver_place = device.place("driver");
  if (device.has("unplug")) spec.unplug = device.span("unplug", reading.scenario.nominal, reading.errors);
  read_return(reading, device, spec);
  read_faults(reading, device, spec);
  spec.age = read_age(reading, device, spec.driver);
  spec.queue = device.text("queue") == "libusb" ? QueuePolicy::libusb : QueuePolicy::hidraw;
  read_motion(reading, device, spec);
  spec.force_delay = device.span("delay", reading.scenario.nominal, reading.errors);
  const Table render = device.table("render");
  spec.emission = render.text("emission") == "hold" ? Emission::hold : Emission::linear;
  spec.render = read_render(render);
  check_springs(render, spec, reading.errors);
  const auto* local = std::get_if<LocalRender>(&spec.render);
  if (local && local->cap.kind == LocalRender::Cap::Kind::by_law && !spec.hand)
    reading.errors.add(render.place("cap"),
                       "'cap': \"law\" follows from the mass and damping of a hand, and this motion is "
                       "programmed; write a stiffness, or motion = { kind = \"hand\", ... }");
  spec.expects_saturation = device.text("saturation") == "expected";
  spec.guard = read_guard(device, reading.scenario.nominal, reading.errors);
  spec.limits = force_limits(spec.guard, {});
  return spec;
}

}  // namespace

void read_devices(ScenarioReading& reading) {
  const Value* devices = reading.document.find("device");
  if (devices == nullptr || !devices->is(Value::Kind::list)) return;
  if (devices->list.empty()) reading.errors.add(devices->place, "there is no [[device]]; a run needs one");
  for (const Value& value : devices->list) {
    if (reading.scenario.devices.size() >= static_cast<std::size_t>(kMaxTools)) {
      reading.errors.add(value.place, fmt::format("more than {} devices", kMaxTools));
      return;
    }
    if (!reading.check.sound(&value)) continue;
    const Table device(&value, "device", value.place);
    check_name(device, reading.scenario.devices, reading.errors);
    reading.scenario.devices.push_back(read_device(reading, device));
  }
  check_strategies(reading);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& device_fields() {
  static const std::vector<Field> rows{
      {.table = "device", .key = "name", .forms = kText,
       .meaning = "Letters, digits, _ and -; the first part of its signals.",
       .required = true, .example = "\"left\""},
      {.table = "device", .key = "driver", .forms = kWord, .default_toml = "\"reference\"",
       .meaning = "The driver code that runs: of the reference device (docs/devices/reference-device.md), or of "
                  "force-feedback devices of the PID class (docs/devices/hid.md), or of all that Linux has a driver for "
                  "(docs/devices/evdev.md), or of a Haply Inverse3 (docs/devices/inverse3.md). `foreign`: one of your own.",
       .words = driver_words()},
      {.table = "device", .key = "transport", .forms = kWord, .default_toml = "\"simulated\"",
       .meaning = "What the driver talks to under the virtual clock.",
       .words = "simulated"},
      {.table = "device", .key = "queue", .forms = kWord, .default_toml = "\"hidraw\"",
       .meaning =
           "What happens to unread reports: `hidraw` keeps 63 and drops the newest, `libusb` keeps 32 and drops the oldest.",
       .words = "hidraw|libusb"},
      {.table = "device", .key = "rate", .forms = kRate, .default_toml = "\"1 kHz\"",
       .meaning = "Rate of the device's ticks (one report in, one force out).",
       .range = between(1, 100'000)},
      {.table = "device", .key = "phase", .forms = kSpan, .default_toml = "\"0 ms\"",
       .meaning = "Its first tick, counted from the start of segment 0; less than one period.",
       .range = at_least(0)},
      {.table = "device", .key = "grab", .forms = kTable,
       .meaning = "How it touches the tissue, and where (tissue only, obligatory there)."},
      {.table = "device", .key = "motion", .forms = kTable,
       .meaning = "How the programmed hand moves. Default: it stays at the origin."},
      {.table = "device", .key = "delay", .forms = kSpan, .default_toml = "\"0 s\"",
       .meaning = "From the tick that sends a force to when a `hand` feels it. A programmed motion feels none.",
       .range = between(0, 1)},
      {.table = "device", .key = "render", .forms = kTable, .meaning = "How scheduled forces reach the device."},
      {.table = "device",
       .key = "force_limit",
       .forms = kQuantity,
       .meaning = "A longer force vector is shortened to this before it is sent. Default: 100 N; with `--device` 3 N.",
       .dimension = D::force,
       .range = above(0, 1e12),  // ForceLimits::max_N
       .example = "\"3 N\""},
      {.table = "device", .key = "slew_limit", .forms = kQuantity,
       .meaning = "Largest change of the force per time. Default: 1000 kN/s; with `--device` 1 kN/s.",
       .dimension = D::slew, .range = above(0), .example = "\"1 kN/s\""},
      {.table = "device", .key = "saturation", .forms = kWord, .default_toml = "\"error\"",
       .meaning = "What a limit on the force or on the range of the device means for the shape of a signal "
                  "(docs/reference/metrics.md): `error`: an expectation on it is an error; `expected`: it is judged as it "
                  "is.",
       .words = "error|expected"},
      {.table = "device", .key = "unplug", .forms = kSpan,
       .meaning = "The simulated device is gone from then on. Default: it stays.",
       .range = between(0, kLongestRun_s), .example = "\"1 s\""},
      {.table = "device", .key = "returns", .forms = kSpan,
       .meaning =
           "After `unplug`: the simulated device is plugged in again. Its driver looks for it four times a second, for "
           "10 s. `reference`, `evdev` and `inverse3` alone (docs/timings/recovery.md). Default: never.",
       .range = between(0, kLongestRun_s), .example = "\"1.5 s\""},
      {.table = "device", .key = "faults", .forms = kTable, .shape = Shape::list,
       .meaning = "What happens to reports of the simulated device."},
      {.table = "device.faults", .key = "kind", .forms = kWord,
       .meaning = "`lost`, `duplicated` (amount times more), `late` (by amount ticks), `cut` (to amount bytes), `longer` "
                  "(by amount "
                  "bytes), `unknown-id`: the report of one tick. `unread`: nothing is read until the next tick, as if the "
                  "host hung. "
                  "`interrupted` reads, `write-lost`, `write-rejected` (at once), `write-refused` (later): amount of them.",
       .words = "lost|duplicated|late|cut|longer|unknown-id|interrupted|unread|write-lost|write-rejected|write-refused",
       .required = true, .example = "\"lost\""},
      {.table = "device.faults", .key = "at", .forms = kSpan,
       .meaning = "The first tick at or after this time.",
       .required = true, .range = between(0, kLongestRun_s), .example = "\"1 s\""},
      {.table = "device.faults", .key = "amount", .forms = kInteger, .default_toml = "1",
       .meaning = "Times, ticks or bytes, as above.",
       .range = between(1, 100'000)},
      {.table = "device.faults", .key = "ticks", .forms = kInteger, .default_toml = "1",
       .meaning = "So many ticks in a row.",
       .range = between(1, 100'000)},
      {.table = "device", .key = "sample_time", .forms = kWord,
       .meaning =
           "What a sample's time is: when it was `taken`, by the time stamps of the reports, or its `arrival`, when it "
           "was read (docs/devices/ages.md). Default: `taken` with `--device` and where one of the next three keys is "
           "written, if reports have stamps.",
       .words = "taken|arrival", .example = "\"taken\""},
      {.table = "device", .key = "report_age", .forms = kSpan,
       .meaning = "How old a report is at least when it comes. This is subtracted from its time, except for `evdev`, whose "
                  "events are stamped by the host's own clock. Default: 0.",
       .range = between(0, 1), .example = "\"0.3 ms\""},
      {.table = "device", .key = "report_age_jitter", .forms = kSpan,
       .meaning = "A simulated report is older than that by up to this, uniformly distributed; the least latency allows for "
                  "it, also with a real device. Default: 0.",
       .range = between(0, 1), .example = "\"0.2 ms\""},
      {.table = "device", .key = "clock_rate_error", .forms = kQuantity,
       .meaning = "The simulated device's clock, which its ticks and time stamps follow, is faster by this (whole ppm). "
                  "Default: 0.",
       .dimension = D::ratio, .range = between(-0.001, 0.001), .example = "\"50 ppm\""},
      {.table = "device", .key = "guard", .forms = kTable, .meaning = "When a force is cut off, and how it comes back."},
      {.table = "device.guard", .key = "gain", .forms = kNumber,
       .meaning = "Share of each force that is rendered. Default: 1; with `--device` 0.25.",
       .range = above(0, 1), .example = "0.25"},
      {.table = "device.guard", .key = "ramp_up", .forms = kSpan,
       .meaning = "Time over which the force rises at the start and after every cut. Default: none; with `--device` 1 s.",
       .range = between(0, 60), .example = "\"1 s\""},
      {.table = "device.guard", .key = "ramp_down", .forms = kSpan,
       .meaning = "Time over which the force falls to zero when it is cut off. Default: none; with `--device` 50 ms.",
       .range = between(0, 60), .example = "\"50 ms\""},
      {.table = "device.guard", .key = "speed_limit", .forms = kQuantity,
       .meaning =
           "A hand that is faster (over 5 ms) is cut off until it is half as fast. Default: never; with `--device` 1 m/s.",
       .dimension = D::velocity, .range = above(0), .example = "\"1 m/s\""},
      {.table = "device.guard", .key = "stale_force", .forms = kSpan,
       .meaning = "The force is cut off when the newest one of the schedule was due this long ago. Default: never; with "
                  "`--device` 100 ms.",
       .range = between(0, 60), .example = "\"100 ms\""},
      {.table = "device.guard", .key = "stale_hand", .forms = kSpan,
       .meaning =
           "The force is cut off when the device has not reported for this time. Default: never; with `--device` 50 ms.",
       .range = between(0, 60), .example = "\"50 ms\""},
      {.table = "device.grab", .key = "center", .forms = kQuantity, .shape = Shape::three,
       .meaning = "In the block's coordinates: the origin is its minimum corner.",
       .required = true, .dimension = D::length, .example = "[\"65 mm\", \"65 mm\", \"135 mm\"]"},
      {.table = "device.grab", .key = "radius", .forms = kQuantity,
       .meaning = "Particles within it are held; for a `probe`, the radius of its sphere.",
       .required = true, .dimension = D::length, .range = above(0), .example = "\"6 mm\""},
      {.table = "device.grab", .key = "coupling", .forms = kWord, .default_toml = "\"grab\"",
       .meaning =
           "`grab`: particles move rigidly with the tool. `spring`: a spring and a damper from the tool to them. `probe`: "
           "a sphere that pushes what is inside it outwards and never pulls.",
       .words = "grab|spring|probe"},
      {.table = "device.grab", .key = "stiffness", .forms = kQuantity,
       .meaning = "For `spring`, of the whole coupling, shared evenly by its particles; for `probe`, against each particle "
                  "that it touches.",
       .kinds = "spring|probe", .required = true, .dimension = D::stiffness, .range = above(0)},
      {.table = "device.grab", .key = "damping", .forms = kQuantity, .default_toml = "\"0 N s/m\"",
       .meaning = "Of the whole coupling, shared evenly by its particles.",
       .kinds = "spring", .dimension = D::damping, .range = at_least(0)},
      {.table = "device.render", .key = "kind", .forms = kWord, .default_toml = "\"force\"",
       .meaning =
           "What a tick sends (docs/forces/stiffness.md). `force`: the scheduled force itself. `local`: with the contact's "
           "stiffness, "
           "corrected for where the hand is by now. `device_spring`: the same as springs that the device renders at its own "
           "rate, with a force for what it cannot. `smith`: corrected by a model of one mode.",
       .words = "force|local|device_spring|smith"},
      {.table = "device.render", .key = "emission", .forms = kWord, .default_toml = "\"linear\"",
       .meaning = "`hold`: the latest scheduled force. `linear`: interpolated between two; costs one slot more latency.",
       .words = "linear|hold"},
      {.table = "device.render", .key = "alpha", .forms = kWord | kNumber, .default_toml = "1.0",
       .meaning = "Factor on the local stiffness that is played. `auto`: what makes up for the latency, and 0.07 more; 1 "
                  "where the hand's damping allows more than that.",
       .words = "auto", .kinds = "local|device_spring", .range = above(0, 4)},
      {.table = "device.render", .key = "stiffness", .forms = kWord, .default_toml = "\"instantaneous\"",
       .meaning = "Which one the solver reports, as `local_model` of [scene], which this sets.",
       .words = "instantaneous|settled", .kinds = "local|device_spring"},
      {.table = "device.render", .key = "gap", .forms = kBoolean, .default_toml = "true",
       .meaning =
           "Whether the distance to a surface that is not touched is used. `false` is a control: the touch then comes late, "
           "with a jump.",
       .kinds = "local|device_spring"},
      {.table = "device.render", .key = "directions", .forms = kWord, .default_toml = "\"all\"",
       .meaning = "In which directions the stiffness answers the hand. `normal`: of a contact that only pushes, along its "
                  "normal alone, which is better where a probe slides. `axes`: the diagonal of the matrix, a control.",
       .words = "all|normal|axes", .kinds = "local|device_spring"},
      {.table = "device.render", .key = "coupled", .forms = kBoolean, .default_toml = "false",
       .meaning =
           "Whether the force follows the other hand, too, by the stiffness that couples them through the tissue. For "
           "two hands that hold one [scene] of kind `tissue` by grab or spring.",
       .kinds = "local|device_spring"},
      {.table = "device.render", .key = "cap", .forms = kWord | kQuantity,
       .meaning = "A stiffer contact is played as stiff as this, along its stiff directions, force and stiffness alike. "
                  "`law`: nine "
                  "tenths of the largest stable stiffness of a spring in this device's `hand`. Default: none.",
       .words = "law", .kinds = "local|device_spring", .dimension = D::stiffness, .range = above(0),
       .example = "\"2000 N/m\""},
      {.table = "device.render", .key = "frequency", .forms = kRate,
       .meaning = "Frequency of the model's mass between its springs while the tool is held still. Default: that of a scene "
                  "of kind `mode`.",
       .kinds = "smith", .range = above(0, 1000), .example = "\"7 Hz\""},
      {.table = "device.render", .key = "damping_ratio", .forms = kNumber,
       .meaning = "Damping ratio of that mass; 1 is critical. Default: that of a scene of kind `mode`.",
       .kinds = "smith", .range = between(0, 10), .example = "0.1"},
      {.table = "device.render", .key = "static_stiffness", .forms = kQuantity,
       .meaning = "What the tool feels when the mass has come to rest; each of the two springs has twice that. Default: the "
                  "scene's, of kind `mode`.",
       .kinds = "smith", .dimension = D::stiffness, .range = above(0)},
      {.table = "device.render", .key = "factor", .forms = kNumber, .default_toml = "1.1",
       .meaning = "Factor on the stiffness of both springs of the model. A model that is too stiff costs little, one that "
                  "is too soft costs much.",
       .kinds = "smith", .range = above(0, 4)},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
