// --set path=value
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <charconv>
#include <optional>

#include "evenstep/format/load.h"

namespace evenstep::internal {
namespace {

/// The index that an element of a list is called by: a number, or its `name`; empty if there is no such element.
std::optional<std::size_t> index_of(const Value& list, std::string_view which) {
  std::size_t index = 0;
  const auto number = std::from_chars(which.data(), which.data() + which.size(), index);
  if (number.ec == std::errc{} && number.ptr == which.data() + which.size())
    return index < list.list.size() ? std::optional(index) : std::nullopt;
  const auto found = std::find_if(list.list.begin(), list.list.end(), [&](const Value& candidate) {
    const Value* name = candidate.find("name");
    return name != nullptr && name->is(Value::Kind::text) && name->text == which;
  });
  if (found == list.list.end()) return std::nullopt;
  return static_cast<std::size_t>(found - list.list.begin());
}

/// The element of a list by index or by its `name`; nullptr and an error if there is none.
Value* element(Value& list, std::string_view which, const Place& place, Errors& errors) {
  if (const std::optional<std::size_t> index = index_of(list, which)) return &list.list[*index];
  if (which.find_first_not_of("0123456789") == std::string_view::npos) {
    errors.add(place, fmt::format("there is no element {}; the list has {}, counted from 0", which, list.list.size()));
    return nullptr;
  }
  std::vector<std::string_view> names;
  for (const Value& candidate : list.list) {
    const Value* name = candidate.find("name");
    if (name != nullptr && name->is(Value::Kind::text)) names.push_back(name->text);
  }
  errors.add(place, fmt::format("there is no element named '{}'; write an index from 0{}{}", which,
                                names.empty() ? "" : " or one of: ", fmt::join(names, ", ")));
  return nullptr;
}

/// The value below `at` that `key` names; a key that is missing in a table is added.
Value* descend(Value& at, std::string_view key, const Place& place, Errors& errors) {
  if (at.is(Value::Kind::list)) return element(at, key, place, errors);
  if (!at.is(Value::Kind::table)) {
    errors.add(place, fmt::format("there is nothing below {}, so no '{}'", as_written(at), key));
    return nullptr;
  }
  if (Value* found = at.find(key)) return found;
  Value empty;
  empty.place = place;
  at.table.push_back({std::string(key), place, std::move(empty)});
  return &at.table.back().value;
}

}  // namespace

bool set_value(Value& document, std::string_view path, Value value, Errors& errors) {
  const Place place = value.place;
  Value* at = &document;
  while (at != nullptr) {
    const std::size_t dot = path.find('.');
    const std::string_view key = path.substr(0, dot);
    if (key.empty()) {
      errors.add(place, "the path has an empty part; write it like device.0.rate");
      return false;
    }
    at = descend(*at, key, place, errors);
    if (dot == std::string_view::npos) break;
    path.remove_prefix(dot + 1);
  }
  if (at == nullptr) return false;
  *at = std::move(value);
  return true;
}

std::string indexed_path(const Value& document, std::string_view path) {
  std::string out;
  for (const Value* at = &document;;) {
    const std::size_t dot = path.find('.');
    const std::string_view key = path.substr(0, dot);
    const std::optional<std::size_t> index = at->is(Value::Kind::list) ? index_of(*at, key) : std::nullopt;
    const Value* const next = index ? &at->list[*index] : at->find(key);
    if (next == nullptr) return out + std::string(path);
    out += index ? std::to_string(*index) : std::string(key);
    if (dot == std::string_view::npos) return out;
    out += '.';
    path.remove_prefix(dot + 1);
    at = next;
  }
}

bool is_within(std::string_view path, std::string_view around) {
  return path.starts_with(around) && (path.size() == around.size() || path[around.size()] == '.');
}

void apply_overrides(Value& document, const std::vector<std::string>& assignments, Errors& errors) {
  struct Applied {
    std::string indexed;
    std::string_view path;
    Place place;
  };
  std::vector<Applied> applied;
  for (const std::string& assignment : assignments) {
    const Place place{"--set " + assignment, 0, 0};
    const std::size_t equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) {
      errors.add(place, "write path=value, such as --set timing.visualization='22.2 ms'");
      continue;
    }
    const std::string_view path = std::string_view(assignment).substr(0, equals);
    if (path == "extends" || path == "expect_append") {
      errors.add(place, fmt::format("'{}' joins files before --set is applied; write it in a file", path));
      continue;
    }
    const std::string indexed = indexed_path(document, path);
    for (const Applied& earlier : applied) {
      if (is_within(earlier.indexed, indexed) && earlier.path != path)
        errors.add(place, fmt::format("sets again what {} has set, which has no effect then; {}", earlier.place.file,
                                      earlier.indexed == indexed ? "remove one of them" : "write this one first"));
    }
    set_value(document, path, parse_toml_value(std::string_view(assignment).substr(equals + 1), place), errors);
    applied.push_back({indexed, path, place});
  }
}

}  // namespace evenstep::internal
