#include "scenario_text.h"

#include <algorithm>

namespace evenstep::testing {
namespace {

std::string written_key(const std::string& key) {
  const bool bare =
      key.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") == std::string::npos;
  return bare ? key : '"' + key + '"';
}

void append(ScenarioText& out, std::string line, ScenarioPlace place) {
  out.toml += std::move(line) + '\n';
  out.places.push_back(std::move(place));
}

void append_table(ScenarioText& out, ScenarioTable& table, const std::string& path) {
  for (const ScenarioTable::Entry& entry : table.entries) {
    if (!entry.toml.empty()) append(out, written_key(entry.key) + " = " + entry.toml, {&table, entry.key});
  }
  for (ScenarioTable::Entry& entry : table.entries) {
    const std::string inner = path.empty() ? written_key(entry.key) : path + '.' + written_key(entry.key);
    for (std::size_t i = 0; i < entry.tables.size(); ++i) {
      append(out, entry.is_list ? "[[" + inner + "]]" : '[' + inner + ']', {&table, entry.key, i});
      append_table(out, entry.tables[i], inner);
    }
  }
}

}  // namespace

ScenarioTable::Entry* ScenarioTable::find(std::string_view key) {
  const auto found = std::find_if(entries.begin(), entries.end(), [&](const Entry& entry) { return entry.key == key; });
  return found == entries.end() ? nullptr : &*found;
}
const ScenarioTable::Entry* ScenarioTable::find(std::string_view key) const {
  return const_cast<ScenarioTable*>(this)->find(key);
}

void ScenarioTable::set(std::string_view key, std::string toml) {
  if (Entry* const entry = find(key)) {
    entry->toml = std::move(toml);
    entry->tables.clear();
  } else {
    entries.push_back({std::string(key), std::move(toml), {}, false});
  }
}

void ScenarioTable::erase(std::string_view key) {
  std::erase_if(entries, [&](const Entry& entry) { return entry.key == key; });
}

ScenarioText to_text(ScenarioTable& root) {
  ScenarioText out;
  append_table(out, root, "");
  return out;
}

std::vector<ScenarioTable*> tables_at(ScenarioTable& root, std::string_view path) {
  std::vector<ScenarioTable*> found{&root};
  while (!path.empty()) {
    const std::size_t dot = std::min(path.find('.'), path.size());
    std::vector<ScenarioTable*> inner;
    for (ScenarioTable* const table : found) {
      for (ScenarioTable::Entry& entry : table->entries)
        if (entry.key == path.substr(0, dot) || path.substr(0, dot) == "*")
          for (ScenarioTable& one : entry.tables) inner.push_back(&one);
    }
    found = std::move(inner);
    path.remove_prefix(std::min(dot + 1, path.size()));
  }
  return found;
}

}  // namespace evenstep::testing
