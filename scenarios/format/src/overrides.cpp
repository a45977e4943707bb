// --set path=value
#include <fmt/format.h>

#include <charconv>

#include "evenstep/format/load.h"

namespace evenstep::internal {
namespace {

/// The element of a list by index or by its `name`; nullptr and an error if there is none.
Value* element(Value& list, std::string_view which, const Place& place, Errors& errors) {
  std::size_t index = 0;
  const auto number = std::from_chars(which.data(), which.data() + which.size(), index);
  if (number.ec == std::errc{} && number.ptr == which.data() + which.size()) {
    if (index < list.list.size()) return &list.list[index];
    errors.add(place, fmt::format("there is no element {}; the list has {}, counted from 0", index, list.list.size()));
    return nullptr;
  }
  std::string names;
  for (Value& candidate : list.list) {
    const Value* name = candidate.find("name");
    if (name == nullptr || !name->is(Value::Kind::text)) continue;
    if (name->text == which) return &candidate;
    names += (names.empty() ? "" : ", ") + name->text;
  }
  errors.add(place, fmt::format("there is no element named '{}'; write an index from 0{}{}", which,
                                names.empty() ? "" : " or one of: ", names));
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

void apply_override(Value& document, const std::string& assignment, Errors& errors) {
  const Place place{"--set " + assignment, 0, 0};
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0) {
    errors.add(place, "write path=value, such as --set timing.visualization='22.2 ms'");
    return;
  }
  const std::string_view path = std::string_view(assignment).substr(0, equals);
  if (path == "extends" || path == "expect_append") {
    errors.add(place, fmt::format("'{}' joins files before --set is applied; write it in a file", path));
    return;
  }
  set_value(document, path, parse_toml_value(std::string_view(assignment).substr(equals + 1), place), errors);
}

}  // namespace evenstep::internal
