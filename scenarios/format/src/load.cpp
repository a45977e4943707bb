#include "evenstep/format/load.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/text/text_file.h"

namespace evenstep::internal {
namespace {

/// Merges `over` into `base`. Values and places of `over` are used, so that an error points at the line that counts.
void merge(Value& base, Value over) {
  if (!base.is(Value::Kind::table) || !over.is(Value::Kind::table)) {
    base = std::move(over);
    return;
  }
  base.place = over.place;
  for (Entry& entry : over.table) {
    const auto same = std::find_if(base.table.begin(), base.table.end(), [&](const Entry& e) { return e.key == entry.key; });
    if (same == base.table.end()) {
      base.table.push_back(std::move(entry));
    } else {
      same->place = entry.place;
      merge(same->value, std::move(entry.value));
    }
  }
}

Value take(Value& table, std::string_view key) {
  const auto found = std::find_if(table.table.begin(), table.table.end(), [&](const Entry& e) { return e.key == key; });
  Value value = std::move(found->value);
  table.table.erase(found);
  return value;
}

/// Moves expect_append of `document` to the end of its expect.
void append_expectations(Value& document, Errors& errors) {
  if (document.find("expect_append") == nullptr) return;
  Value more = take(document, "expect_append");
  if (!more.is(Value::Kind::list)) {
    errors.add(more.place, "'expect_append' must be a list of tables; write [[expect_append]]");
    return;
  }
  if (document.find("expect") == nullptr) {
    document.table.push_back({"expect", more.place, std::move(more)});
    return;
  }
  Value& expect = *document.find("expect");
  for (Value& expectation : more.list) expect.list.push_back(std::move(expectation));
}

/// Whether the file has a known format. In a later format the same keys may have another meaning, so nothing else in such a
/// file is checked.
bool format_is_known(const Value& document, const std::string& path, Errors& errors) {
  const Value* format = document.find("format");
  if (format == nullptr) {
    errors.add({path, 1, 1}, fmt::format("no 'format'; write format = {} at the top", kScenarioFormat));
    return false;
  }
  if (!format->is(Value::Kind::integer) || format->integer != kScenarioFormat) {
    errors.add(format->place, fmt::format("format = {} is not known to this version, which reads format = {}",
                                          as_written(*format), kScenarioFormat));
    return false;
  }
  return true;
}

std::string same_file_key(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::weakly_canonical(path, ignored).string();
}

struct Step {
  std::string path, key;
};

Value load(const std::string& path, const Place& named_at, std::vector<Step>& chain, Errors& errors);

/// Merges the base files of `document`, and removes `extends` from it.
Value load_bases(Value& document, std::vector<Step>& chain, Errors& errors) {
  Value merged;
  if (document.find("extends") == nullptr) return merged;
  const Value extends = take(document, "extends");
  const bool texts = extends.is(Value::Kind::list) && std::all_of(extends.list.begin(), extends.list.end(),
                                                                  [](const Value& v) { return v.is(Value::Kind::text); });
  if (!texts) {
    errors.add(extends.place, "'extends' must be a list of files, such as [\"base.toml\"]");
    return merged;
  }
  for (const Value& base : extends.list) merge(merged, load(path_from(base), base.place, chain, errors));
  return merged;
}

Value load(const std::string& path, const Place& named_at, std::vector<Step>& chain, Errors& errors) {
  const Step step{path, same_file_key(path)};
  const auto same = std::find_if(chain.begin(), chain.end(), [&](const Step& s) { return s.key == step.key; });
  if (same != chain.end()) {
    std::string names;
    for (auto s = same; s != chain.end(); ++s) names += s->path + " -> ";
    errors.add(named_at, fmt::format("'extends' goes in a circle: {}{}", names, path));
    return {};
  }
  if (chain.size() >= kMostExtendsDepth) {
    errors.add(named_at, fmt::format("'extends' is deeper than {} files", kMostExtendsDepth));
    return {};
  }
  const Result<std::string> file = read_text_file(path, kMostScenarioBytes);
  if (!file) {
    errors.add(named_at, named_at.line == 0 ? file.error() : fmt::format("'{}' {}", path, file.error()));
    return {};
  }
  const std::size_t errors_before = errors.count();
  Value document = parse_toml(*file, path, errors);
  if (errors.count() > errors_before || !format_is_known(document, path, errors)) return {};

  chain.push_back(step);
  Value merged = load_bases(document, chain, errors);
  chain.pop_back();
  Value more;
  more.place = document.place;
  if (document.find("expect_append") != nullptr)
    more.table.push_back({"expect_append", document.place, take(document, "expect_append")});
  merge(merged, std::move(document));
  merge(merged, std::move(more));
  append_expectations(merged, errors);
  return merged;
}

}  // namespace

Value load_document(const std::string& path, Errors& errors) {
  std::vector<Step> chain;
  return load(path, {path, 0, 0}, chain, errors);
}

std::string path_from(const Value& path) {
  namespace fs = std::filesystem;
  if (path.place.line == 0) return path.text;  // written on the command line
  return (fs::path(path.place.file).parent_path() / path.text).lexically_normal().string();
}

}  // namespace evenstep::internal
