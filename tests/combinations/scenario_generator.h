#pragma once
/// Random scenarios, made from the field table of the format: a new key takes part without being named here. What excludes
/// what is not written down a second time: the reader refuses it with a line, and what stands in that line is drawn again or
/// left out, until the reader takes the scenario.

#include <map>
#include <random>
#include <string>
#include <vector>

#include "evenstep/format/fields.h"
#include "evenstep/format/scenario.h"
#include "scenario_text.h"

namespace evenstep::testing {

struct GeneratedScenario {
  ScenarioTable root;
  std::string toml;
  bool is_valid = false;  ///< the reader takes it
};

class ScenarioGenerator {
 public:
  /// The scenarios are read as FOLDER/scenario.toml, and name recordings that lie in it (write_recordings).
  ScenarioGenerator(std::uint64_t seed, std::string folder, Registry registry = {});

  /// One that the reader takes; `richness` is the share of the keys that need not be there.
  GeneratedScenario scenario(double richness);
  /// The same with this key in it.
  GeneratedScenario scenario_with(const internal::Field& wanted, double richness);
  /// As the tables are drawn: the reader may refuse it.
  GeneratedScenario unrepaired(double richness);

  /// A value for this key, as TOML.
  std::string value_of(const internal::Field& field);
  std::uint64_t below(std::uint64_t count) { return random_() % count; }
  bool chance(double share) { return static_cast<double>(random_() % 1'000'000) < share * 1e6; }

 private:
  GeneratedScenario drawn(double richness, const internal::Field* wanted);
  void repair(GeneratedScenario& scenario);
  void repair_at(GeneratedScenario& scenario, const ScenarioPlace& at, std::map<std::string, int>& tries);
  void draw_section_again(GeneratedScenario& scenario);
  ScenarioTable::Entry entry_of(const internal::Field& field, const std::string& kind);
  /// The value that this key must have beside the wanted one, or an empty one if it must only be there; nullptr: neither.
  const std::string_view* companion(std::string_view table, std::string_view key) const;
  static bool is_kind_key(const internal::Field& field);
  ScenarioTable table(std::string_view name);
  std::string kind_of(std::string_view table);
  bool is_wanted(std::string_view table, std::string_view key) const;

  std::mt19937_64 random_;
  std::string folder_;
  ReadOptions options_;
  double richness_ = 0;
  const internal::Field* wanted_ = nullptr;
};

/// Recordings of steps and of a hand for the scenarios of a generator.
void write_recordings(const std::string& folder);

/// The key in a table of the format, "device.motion.kind", for messages.
std::string name_of(const internal::Field& field);

}  // namespace evenstep::testing
