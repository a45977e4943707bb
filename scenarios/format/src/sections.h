#pragma once
/// One function per part of a scenario. Each relies on the others only as its comment says, and skips a part in which the
/// check found errors, because errors that only follow from another one are noise.

#include "check.h"

namespace evenstep::internal {

struct ScenarioReading {
  const Value& document;
  const Check& check;
  Errors& errors;
  Scenario& scenario;
  const Registry& registry;

  /// The section, or its defaults if it is not there.
  Table section(std::string_view name) const;
  bool sound(std::string_view name) const;
};

/// `name` and `options` of a part that the program registers.
Foreign read_foreign(const Table& table);
/// The error that the program does not have this part; `known` are the names that it has.
void add_unregistered(const char* kind, const Foreign& part, const std::vector<std::string_view>& known, Errors& errors);
/// The function that makes this part; an empty one, and an error, if the program has not registered it.
template <class Parts>
typename Parts::mapped_type registered(const char* kind, const Foreign& part, const Parts& parts, Errors& errors) {
  if (const auto found = parts.find(part.name); found != parts.end()) return found->second;
  std::vector<std::string_view> known;
  for (const auto& [name, make] : parts) known.push_back(name);
  add_unregistered(kind, part, known, errors);
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
void read_case(ScenarioReading& reading);
void read_study(ScenarioReading& reading);  ///< after read_scene
void read_sweep(ScenarioReading& reading);
void read_expectations(ScenarioReading& reading);  ///< after read_timing

std::string in_ms(Duration duration);  ///< "11.1 ms"
inline double in_Hz(Rate rate) { return static_cast<double>(rate.num) / static_cast<double>(rate.den); }

}  // namespace evenstep::internal
