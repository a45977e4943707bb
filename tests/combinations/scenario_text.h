#pragma once
/// A scenario as a tree of tables, as TOML with every value on a line of its own, so that the line of an error names the
/// value.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace evenstep::testing {

struct ScenarioTable {
  struct Entry {
    std::string key;
    std::string toml;                   ///< the value; empty: `tables` are
    std::vector<ScenarioTable> tables;  ///< one, or the elements of a list of tables
    bool is_list = false;
  };
  std::vector<Entry> entries;

  Entry* find(std::string_view key);
  const Entry* find(std::string_view key) const;
  bool has(std::string_view key) const { return find(key) != nullptr; }
  /// Sets a value at its place; a new one comes last.
  void set(std::string_view key, std::string toml);
  void erase(std::string_view key);
};

/// What stands in a line.
struct ScenarioPlace {
  ScenarioTable* table = nullptr;  ///< the one that contains the entry
  std::string key;
  std::size_t element = 0;  ///< in a list of tables: which one
};

/// A tree as TOML. `places` has one for each line, from line 1 on; they are valid until the tree changes.
struct ScenarioText {
  std::string toml;
  std::vector<ScenarioPlace> places;
};
ScenarioText to_text(ScenarioTable& root);

/// The tables at a path such as "device.motion": of a list all elements, and for "*" all tables.
std::vector<ScenarioTable*> tables_at(ScenarioTable& root, std::string_view path);

}  // namespace evenstep::testing
