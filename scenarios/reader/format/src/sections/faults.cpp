// What the faults of a scenario are, from when until when; and [recovery]
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "evenstep/device/looked_for.h"

#include "src/faults.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

using Over = ProgrammedFault::Over;

/// What is drawn at random goes on until the end of the run, unless [timing] disturbed says when it is over.
std::optional<ProgrammedFault> timing_fault(const std::string& key, const ProgrammedTiming& timing, RealTime end) {
  if (key == "changes") {
    if (timing.changes.empty()) return std::nullopt;
    RealTime last = timing.changes.front().at;
    for (const TimingChange& change : timing.changes) last = change.at < end ? change.at : last;
    return ProgrammedFault{"", timing.changes.front().at, last, Over::with_segment};
  }
  if (key == "dropped_visualization" && timing.dropped_visualization == 0) return std::nullopt;
  if (key == "merged_visualization" && timing.merged_visualization == 0) return std::nullopt;
  if (timing.disturbed) return ProgrammedFault{"", timing.disturbed->from, timing.disturbed->to, Over::with_segment};
  if (key != "hitch") return ProgrammedFault{"", RealTime{0}, end, Over::never};
  const std::int64_t every = timing.hitch->every.ns;
  return ProgrammedFault{"", RealTime{every}, RealTime{(end.ns - 1) / every * every}, Over::after_segment};
}

/// From the first tick that it affects to the first one that it does not.
ProgrammedFault report_fault(const Table& fault, const DeviceSpec& device, const NominalUnits& nominal, Errors& errors) {
  const RealTime phase{device.phase.ns}, at{fault.span("at", nominal, errors).ns};
  const std::int64_t first = first_tick_at_or_after(device.rate, at, phase), ticks = fault.integer("ticks");
  const std::string kind = fault.text("kind");
  const std::int64_t after = kind == "late"               ? fault.integer("amount") + 1
                             : kind.starts_with("write-") ? fault.integer("amount")
                                                          : 1;
  return {"", tick_time(device.rate, first, phase), tick_time(device.rate, first + ticks - 1 + after, phase), Over::at_time};
}

/// A switch that is turned back ends it.
std::optional<ProgrammedFault> switch_fault(const std::vector<Table>& events, const NominalUnits& nominal, Errors& errors) {
  if (events.empty()) return std::nullopt;
  ProgrammedFault fault{"", RealTime{events.front().span("at", nominal, errors).ns}, {}, Over::at_time};
  std::map<std::string, bool> on;
  for (const Table& event : events) {
    fault.to = RealTime{event.span("at", nominal, errors).ns};
    on[event.text("kind")] = event.boolean("on");
  }
  if (std::any_of(on.begin(), on.end(), [](const auto& one) { return !one.second; })) fault.over = Over::never;
  return fault;
}

std::optional<ProgrammedFault> device_fault(const FaultPlace& place, const Table& table, const DeviceSpec& device,
                                            const NominalUnits& nominal, Errors& errors) {
  if (place.key == "faults") return report_fault(table.tables("faults")[place.entry], device, nominal, errors);
  if (place.key == "events") return switch_fault(table.tables("events"), nominal, errors);
  if (place.key == "unplug") {
    const RealTime at{device.unplug->ns};
    if (!device.returns || !found_again(at, RealTime{device.returns->ns})) return ProgrammedFault{"", at, at, Over::never};
    return ProgrammedFault{"", at, RealTime{device.returns->ns}, Over::at_time};
  }
  if (place.key == "evdev.meddled_at") {  // an instant, after which the driver plays all of it again
    const RealTime at{table.table("evdev").duration("meddled_at").ns};
    return ProgrammedFault{"", at, at, Over::at_time};
  }
  const RealTime at{table.table("inverse3").duration("uncalibrated_at").ns};
  return ProgrammedFault{"", at, at, Over::never};
}

/// Where a fault is written, and when it begins there (a report's fault then waits for the next tick).
std::pair<Place, RealTime> written(const FaultPlace& place, RealTime from, ScenarioReading& reading) {
  if (place.of_timing) return {reading.section("timing").place(place.key), from};
  const Value& value = reading.document.find("device")->list[place.device];
  const Table device(&value, "device", value.place);
  if (place.key != "faults") return {device.place(place.key.substr(0, place.key.find('.'))), from};
  const Table fault = device.tables("faults")[place.entry];
  return {fault.place("at"), RealTime{fault.span("at", reading.scenario.nominal, reading.errors).ns}};
}

/// Refuses what would begin after the end of the run: the scenario would not test what it is meant to.
bool comes_too_late(const std::string& what, RealTime at, const Place& place, ScenarioReading& reading) {
  const Duration run = reading.scenario.run_duration;
  if (at < RealTime{run.ns}) return false;
  reading.errors.add(place,
                     fmt::format("'{}': the run has ended by {}, before this begins; let it begin earlier, run longer, "
                                 "or remove it",
                                 what, in_ms(run)));
  return true;
}

/// Of what is not a fault of its own: the further entries of a list.
void check_begins(ScenarioReading& reading) {
  const std::vector<TimingChange>& changes = reading.scenario.timing.programmed.changes;
  for (std::size_t i = 1; i < changes.size(); ++i) {
    comes_too_late(fmt::format("timing.changes.{}", i), changes[i].at,
                   reading.section("timing").tables("changes")[i].place("at"), reading);
  }
  for (std::size_t d = 0; d < reading.scenario.devices.size(); ++d) {
    const DeviceSpec& device = reading.scenario.devices[d];
    const Value& value = reading.document.find("device")->list[d];
    const Table table(&value, "device", value.place);
    const std::vector<Table> events = table.tables("events");
    for (std::size_t i = 1; i < events.size(); ++i)
      comes_too_late(fmt::format("device.{}.events.{}", device.name, i),
                     RealTime{events[i].span("at", reading.scenario.nominal, reading.errors).ns}, events[i].place("at"),
                     reading);
  }
}

/// A swarm needs faults, and a run that may go on without them.
void check_swarm(ScenarioReading& reading) {
  const Scenario& scenario = reading.scenario;
  if (!scenario.sweep || !scenario.sweep->swarm) return;
  if (scenario.faults.empty() && !scenario.has_faults_off)
    reading.errors.add(scenario.sweep->swarm_place,
                       "'swarm': this scenario programs no fault that could be switched off (docs/timings/recovery.md); "
                       "remove it");
  if (reading.document.find("expect_stop") != nullptr)
    reading.errors.add(scenario.sweep->swarm_place,
                       "'swarm' does not go with [expect_stop]: with its fault switched off the run would not stop");
}

}  // namespace

void read_faults(ScenarioReading& reading) {
  Scenario& scenario = reading.scenario;
  if (reading.sound("recovery")) {
    const Table recovery = reading.section("recovery");
    scenario.recovery_latency = recovery.span("latency", scenario.nominal, reading.errors);
    scenario.recovery_jump = recovery.si("jump");
  }
  if (reading.sound("run")) scenario.has_faults_off = !reading.section("run").at("faults_off").list.empty();
  if (reading.errors.any()) return;
  const RealTime end{scenario.run_duration.ns};
  for (const FaultPlace& place : fault_places(reading.document)) {
    std::optional<ProgrammedFault> fault;
    if (place.of_timing) {
      fault = timing_fault(place.key, scenario.timing.programmed, end);
    } else {
      const Value& value = reading.document.find("device")->list[place.device];
      fault = device_fault(place, Table(&value, "device", value.place), scenario.devices[place.device], scenario.nominal,
                           reading.errors);
    }
    if (!fault) continue;  // it changes nothing
    const auto [at, begin] = written(place, fault->from, reading);
    if (comes_too_late(place.name, begin, at, reading) || fault->from >= end) continue;
    fault->name = place.name;
    scenario.faults.push_back(*fault);
  }
  check_begins(reading);
  check_swarm(reading);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& recovery_fields() {
  static const std::vector<Field> rows{
      {.table = "recovery", .key = "latency", .forms = kSpan, .default_toml = "\"1 ms\"",
       .meaning = "The age of a force may exceed the greatest one before the first fault by this much.",
       .range = between(0, kLongestRun_s)},
      {.table = "recovery", .key = "jump", .forms = kQuantity, .default_toml = "\"10 %\"",
       .meaning = "A jump may exceed the greatest one before the first fault by this share of the mean change from one "
                  "sample to the next.",
       .dimension = D::ratio, .range = between(0, 1000)},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
