// [[device]]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/format/load.h"
#include "evenstep/recordings/motion_csv.h"
#include "sections.h"

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

RecordedMotion read_recorded(const Table& motion, Errors& errors) {
  const Value path = motion.at("file");
  MotionCsv csv = read_motion_csv(path_from(path));
  for (const Diagnostic& error : csv.errors) {
    if (error.line == 0) {
      errors.add(path.place, fmt::format("'file': '{}' {}", error.file, error.message));
    } else {
      errors.add({error.file, error.line, error.column}, error.message);
    }
  }
  return std::move(csv.motion);
}

Motion read_stick_slip(const ScenarioReading& reading, const Table& motion) {
  const NominalUnits& nominal = reading.scenario.nominal;
  return StickSlip{motion.vector("velocity"), motion.span("stick", nominal, reading.errors),
                   motion.span("slip", nominal, reading.errors)};
}

Motion read_minimum_jerk(const ScenarioReading& reading, const Table& motion) {
  MinimumJerk out;
  for (const Table& move : motion.tables("moves")) {
    out.moves.push_back({move.vector("to"), move.span("duration", reading.scenario.nominal, reading.errors),
                         move.span("rest", reading.scenario.nominal, reading.errors)});
  }
  if (out.moves.empty())
    reading.errors.add(motion.place("moves"), "'moves' is empty; write [{ to = [\"10 mm\", \"0 mm\", \"0 mm\"], duration = \"0.4 s\" }]");
  return out;
}

Motion read_shape(const ScenarioReading& reading, const Table& motion) {
  const std::string kind = motion.text("kind");
  if (kind == "still") return Still{};
  if (kind == "sine") return Sine{motion.vector("amplitude"), motion.rate("frequency")};
  if (kind == "recorded") return read_recorded(motion, reading.errors);
  const bool spans_known = reading.scenario.nominal.known;  // if not, [timing] is faulty: they may need its units
  if (kind == "minimum-jerk") return spans_known ? read_minimum_jerk(reading, motion) : Motion(Still{});
  if (kind == "stick-slip") return spans_known ? read_stick_slip(reading, motion) : Motion(Still{});
  const ConstantVelocity ramp{motion.vector("velocity"), motion.smooth("start")};
  if (kind == "constant-velocity") return ramp;
  if (!spans_known) return Still{};
  const Duration stop = motion.span("stop", reading.scenario.nominal, reading.errors);
  if (stop < ramp.smooth_start) {
    reading.errors.add(motion.place("stop"), fmt::format("'stop': {} is within the smooth start of {}; stop later",
                                                         in_ms(stop), in_ms(ramp.smooth_start)));
  }
  return RampStop{ramp, RealTime{stop.ns}};
}

ProgrammedMotion read_programmed(const ScenarioReading& reading, const Table& motion) {
  ProgrammedMotion programmed{read_shape(reading, motion), {}};
  if (motion.has("delay")) programmed.begin = RealTime{motion.span("delay", reading.scenario.nominal, reading.errors).ns};
  return programmed;
}

RenderSpec::Cap read_cap(const Table& render) {
  using Kind = RenderSpec::Cap::Kind;
  if (render.text("cap") == "law") return {Kind::by_law, 0};
  return {Kind::fixed, render.si("cap")};
}

RenderSpec read_render(const Table& render) {
  RenderSpec spec;
  const std::string kind = render.text("kind");
  if (kind == "local" || kind == "device_spring") {
    spec.kind = kind == "local" ? RenderSpec::Kind::local : RenderSpec::Kind::device_spring;
    spec.alpha = render.at("alpha").is(Value::Kind::text) ? std::nullopt : std::optional(render.number("alpha"));
    spec.stiffness = render.text("stiffness") == "settled" ? LocalModel::settled : LocalModel::instantaneous;
    spec.knows_gap = render.boolean("gap");
    if (render.has("cap")) spec.cap = read_cap(render);
  } else if (kind == "smith") {
    spec.kind = RenderSpec::Kind::smith;
    if (render.has("frequency")) spec.mode.frequency_Hz = in_Hz(render.rate("frequency"));
    if (render.has("damping_ratio")) spec.mode.damping_ratio = render.number("damping_ratio");
    if (render.has("static_stiffness")) spec.mode.static_N_per_m = render.si("static_stiffness");
    spec.factor = render.number("factor");
  }
  return spec;
}

/// Checks that the integration of the hand can follow its motion (device/hand.h).
void check_hand(const HandSpec& hand, const Table& motion, Errors& errors) {
  const double frequency_per_s = std::sqrt(hand.total_stiffness_N_per_m() / hand.total_mass_kg());
  const double decay_per_s = hand.total_damping_N_s_per_m() / hand.total_mass_kg();
  if (frequency_per_s > kFastestHand_per_s) {
    errors.add(motion.place("mass"), fmt::format("'mass': on its springs the hand swings with {:.4g} /s, and {:g} /s is the most; "
                                                 "write more mass or less stiffness",
                                                 frequency_per_s, kFastestHand_per_s));
  } else if (decay_per_s > kFastestHand_per_s) {
    errors.add(motion.place("mass"), fmt::format("'mass': the damping stops the hand with {:.4g} /s, and {:g} /s is the most; write "
                                                 "more mass or less damping",
                                                 decay_per_s, kFastestHand_per_s));
  }
}

HandSpec read_hand(const Table& motion, Errors& errors) {
  HandSpec hand{motion.si("mass"), motion.si("damping"), motion.si("stiffness")};
  if (motion.has("arm")) {
    const Table arm = motion.table("arm");
    hand.arm = {arm.si("mass"), arm.si("damping"), arm.si("stiffness")};
  }
  hand.push_N = motion.vector("push");
  hand.offset_m = motion.vector("offset");
  hand.velocity_m_per_s = motion.vector("velocity");
  check_hand(hand, motion, errors);
  return hand;
}

void read_motion(const ScenarioReading& reading, const Table& device, DeviceSpec& spec) {
  if (!device.has("motion")) return;
  const Table motion = device.table("motion");
  if (motion.text("kind") != "hand") {
    spec.motion = read_programmed(reading, motion);
    return;
  }
  spec.hand = read_hand(motion, reading.errors);
  if (motion.has("path")) spec.motion = read_programmed(reading, motion.table("path"));
}

/// Refuses the reference twin for a hand: it reads the programmed motion, which a hand does not have.
void check_strategies(const ScenarioReading& reading) {
  const auto& strategies = reading.scenario.strategies;
  if (!has_hand(reading.scenario) || !reading.sound("run")) return;
  if (std::find(strategies.begin(), strategies.end(), StrategyKind::ideal) == strategies.end()) return;
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
  if (spec.render.kind != RenderSpec::Kind::device_spring || (spec.pid && spec.pid->options.full_scale_N)) return;
  errors.add(render.place("kind"), spec.pid ? "'kind': \"device_spring\" needs to know what the device's springs are in N/m; write "
                                              "full_scale in its 'pid'"
                                            : "'kind': \"device_spring\" is for devices that render springs by themselves; write "
                                              "driver = \"pid\", or kind = \"local\", which sends the same as forces");
}

PidSpec read_pid(const ScenarioReading& reading, const Table& device) {
  PidSpec spec;
  const Table pid = device.table("pid");
  spec.options.travel_m = pid.vector("travel");
  if (spec.options.travel_m == glm::dvec3(0))
    reading.errors.add(pid.place("travel"), "'travel': no axis is used; write the travel of one, [\"200 mm\", \"0 mm\", \"0 mm\"]");
  if (pid.has("full_scale")) spec.options.full_scale_N = pid.si("full_scale");
  if (pid.has("full_slope")) spec.options.full_slope_N_per_m = glm::dvec3(pid.si("full_slope"));
  spec.options.springs = device.table("render").text("kind") == "device_spring";
  spec.firmware_rate = pid.rate("firmware_rate");
  spec.options.gain = pid.number("gain");
  spec.options.effect_duration = pid.duration("effect_duration");
  spec.flavour = pid.text("flavour") == "array" ? PidFlavour::array : PidFlavour::mask;
  spec.pool_effects = static_cast<int>(pid.integer("pool"));
  if (pid.has("block_load_error")) spec.block_load_error_at = static_cast<int>(pid.integer("block_load_error")) - 1;
  for (const Table& event : device.tables("events")) {
    const auto kind = event.text("kind") == "safety-switch" ? PidDeviceEvent::Kind::safety_switch : PidDeviceEvent::Kind::actuator_power;
    const RealTime at{event.span("at", reading.scenario.nominal, reading.errors).ns};
    if (!spec.events.empty() && at < spec.events.back().at)
      reading.errors.add(event.place("at"), "'at': earlier than the event before; write them in order of time");
    spec.events.push_back({kind, at, event.boolean("on")});
  }
  return spec;
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

DeviceSpec read_device(ScenarioReading& reading, const Table& device) {
  DeviceSpec spec;
  spec.name = device.text("name");
  spec.rate = device.rate("rate");
  spec.phase = device.span("phase", reading.scenario.nominal, reading.errors);
  if (spec.phase >= period_ceil(spec.rate)) {
    reading.errors.add(device.place("phase"), fmt::format("'phase': {} is a period of {} or more; write the rest",
                                                          in_ms(spec.phase), in_ms(period_ceil(spec.rate))));
  }
  if (device.text("driver") == "pid") spec.pid = read_pid(reading, device);
  if (device.has("unplug")) spec.unplug = device.span("unplug", reading.scenario.nominal, reading.errors);
  read_faults(reading, device, spec);
  spec.queue = device.text("queue") == "libusb" ? QueuePolicy::libusb : QueuePolicy::hidraw;
  read_motion(reading, device, spec);
  spec.force_delay = device.span("delay", reading.scenario.nominal, reading.errors);
  const Table render = device.table("render");
  spec.emission = render.text("emission") == "hold" ? Emission::hold : Emission::linear;
  spec.render = read_render(render);
  check_springs(render, spec, reading.errors);
  if (spec.render.cap.kind == RenderSpec::Cap::Kind::by_law && !spec.hand)
    reading.errors.add(render.place("cap"), "'cap': \"law\" follows from the mass and damping of a hand, and this motion is "
                                            "programmed; write a stiffness, or motion = { kind = \"hand\", ... }");
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

}  // namespace evenstep::internal
