#pragma once
/// One function per part of a scenario. Each relies on the others only as its comment says, and skips a part in which the
/// check found errors, because errors that only follow from another one are noise.

#include <string>
#include <string_view>

#include "check.h"
#include "evenstep/plugins/library.h"

namespace evenstep::internal {

struct ScenarioReading {
  const Value& document;
  const Check& check;
  Errors& errors;
  Scenario& scenario;
  const Registry& registry;
  bool real_time = false;  ///< of ReadOptions

  /// The section, or its defaults if it is not there.
  Table section(std::string_view name) const;
  bool sound(std::string_view name) const;
};

/// Reads the keys of foreign_rows of a part that is not evenstep's own. `must_say_which`: it is an error if the table has
/// neither name nor library.
Foreign read_foreign(const ScenarioReading& reading, const Table& table, bool must_say_which = true);
/// Opens the library that the part names, which gives the part its name; empty, with an error, if that is not possible.
Library library_of(const char* kind, Foreign& part, Errors& errors);
/// The error that the program, or the library, does not have this part; `known` are the names that the program has.
void add_missing(const char* kind, const Foreign& part, const std::vector<std::string_view>& known, Errors& errors);
/// The function that makes this part: what the program has registered under its name, or `in_library` of its library. An
/// empty one, and an error, if there is none.
template <class Parts>
typename Parts::mapped_type maker_of(const char* kind, Foreign& part, const Parts& parts,
                                     typename Parts::mapped_type Library::*in_library, Errors& errors) {
  if (!part.library.empty()) return library_of(kind, part, errors).*in_library;
  if (const auto found = parts.find(part.name); found != parts.end()) return found->second;
  std::vector<std::string_view> known;
  for (const auto& [name, make] : parts) known.push_back(name);
  add_missing(kind, part, known, errors);
  return {};
}

void read_strategies(ScenarioReading& reading);
void read_timing(ScenarioReading& reading);  ///< sets scenario.nominal and, for step_size = "fill", scene.step_rate
void read_run(ScenarioReading& reading);     ///< after read_timing
void read_motion(const ScenarioReading& reading, const Table& device, DeviceSpec& spec);
void read_devices(ScenarioReading& reading);    ///< after read_timing
void read_scene(ScenarioReading& reading);      ///< after read_timing and read_devices
void read_rendering(ScenarioReading& reading);  ///< after read_scene
void read_remap(ScenarioReading& reading);      ///< after read_timing
void read_playing(ScenarioReading& reading);    ///< [source]; after read_timing, read_devices and read_remap
void read_case(ScenarioReading& reading);
void read_study(ScenarioReading& reading);  ///< after read_scene
void read_sweep(ScenarioReading& reading);
void read_faults(ScenarioReading& reading);        ///< after read_run and read_devices
void read_expectations(ScenarioReading& reading);  ///< after read_timing

/// 1 / step_size of [scene]; `filled` for "fill".
Rate read_step_rate(const Table& scene, Rate filled);

/// Adds an error if [[device]] has 'queue' but its driver has no queue; `why_not` says why.
inline void refuse_queue(const Table& device, std::string_view why_not, Errors& errors) {
  if (device.has("queue"))
    errors.add(device.place("queue"),
               "'queue' is about reports on a hidraw or libusb handle, and " + std::string(why_not) + "; remove it");
}

std::string in_ms(Duration duration);  ///< "11.1 ms"
inline double in_Hz(Rate rate) { return static_cast<double>(rate.num) / static_cast<double>(rate.den); }

}  // namespace evenstep::internal
