// The only file that sees toml++ (it costs 2.5 s to compile).
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>

#include "evenstep/format/document.h"

namespace evenstep::internal {
namespace {

/// toml++ limits the nesting of brackets, but not that of dotted keys, and its tables are freed recursively: a megabyte of
/// "a.a.a." would overflow the stack. 32 dots per line times its 256 levels of brackets do not.
constexpr int kMostDotsPerLine = 32;

bool too_many_dots(const std::string& text, std::int64_t& line) {
  int dots = 0;
  line = 1;
  for (const char c : text) {
    if (c == '\n') {
      ++line;
      dots = 0;
    } else if (c == '.' && ++dots > kMostDotsPerLine) {
      return true;
    }
  }
  return false;
}

Place place_of(const toml::source_region& source, const Place& around) {
  if (source.begin.line == 0) return around;  // tables that a dotted key implies have no place of their own
  return {around.file, source.begin.line, source.begin.column};
}

Value convert(const toml::node& node, const Place& around) {
  Value value;
  value.place = place_of(node.source(), around);
  if (const toml::table* table = node.as_table()) {
    value.kind = Value::Kind::table;
    for (const auto& [key, child] : *table) {
      const Place key_place = place_of(key.source(), value.place);
      value.table.push_back({std::string(key.str()), key_place, convert(child, key_place)});
    }
    // toml++ keeps tables in alphabetical order; people read files from top to bottom.
    std::stable_sort(value.table.begin(), value.table.end(), [](const Entry& a, const Entry& b) {
      return std::pair(a.place.line, a.place.column) < std::pair(b.place.line, b.place.column);
    });
  } else if (const toml::array* array = node.as_array()) {
    value.kind = Value::Kind::list;
    for (const toml::node& child : *array) value.list.push_back(convert(child, value.place));
  } else if (const auto* text = node.as_string()) {
    value.kind = Value::Kind::text;
    value.text = text->get();
  } else if (const auto* integer = node.as_integer()) {
    value.kind = Value::Kind::integer;
    value.integer = integer->get();
  } else if (const auto* number = node.as_floating_point()) {
    value.kind = Value::Kind::number;
    value.number = number->get();
  } else if (const auto* boolean = node.as_boolean()) {
    value.kind = Value::Kind::boolean;
    value.boolean = boolean->get();
  } else {
    value.kind = Value::Kind::date;
  }
  return value;
}

toml::table table_of(const Value& value);
toml::array array_of(const Value& value);

template <class Sink>
void give(const Value& value, Sink sink) {
  switch (value.kind) {
    case Value::Kind::boolean:
      return sink(value.boolean);
    case Value::Kind::integer:
      return sink(value.integer);
    case Value::Kind::number:
      return sink(value.number);
    case Value::Kind::text:
      return sink(value.text);
    case Value::Kind::table:
      return sink(table_of(value));
    case Value::Kind::list:
      return sink(array_of(value));
    case Value::Kind::date:
      return;  // no key accepts a date, so a table that was read without errors has none
  }
}

toml::table table_of(const Value& value) {
  toml::table table;
  for (const Entry& entry : value.table) {
    give(entry.value, [&](auto&& v) { table.insert_or_assign(entry.key, std::forward<decltype(v)>(v)); });
  }
  return table;
}

/// Not inside give(): a template that recurses with a new lambda type each time would never end.
toml::array array_of(const Value& value) {
  toml::array array;
  for (const Value& child : value.list) {
    give(child, [&](auto&& v) { array.push_back(std::forward<decltype(v)>(v)); });
  }
  return array;
}

/// toml++ does not know what is most often wrong with a value that it cannot read.
std::string_view quotes_hint(std::string_view error) {
  constexpr std::string_view kOfValue[] = {"could not determine value type", "expected a comment or whitespace",
                                           "while parsing decimal integer", "while parsing floating-point"};
  const bool of_value = std::any_of(std::begin(kOfValue), std::end(kOfValue),
                                    [&](std::string_view known) { return error.find(known) != std::string_view::npos; });
  return of_value ? "; names, and numbers with a unit, are written in quotes: \"spring\", \"11.1 ms\"" : "";
}

/// The header of a recording that was taken for a scenario, or a table twice, which toml++ says in its own words.
std::string remedy(std::string_view error, std::string_view text) {
  if (text.find("begin_ns,end_ns") < std::min(text.find('='), text.size()))
    return "; this is a recording, no scenario: `size`, `fit` and `advise` take it, and [timing] trace in a scenario";
  if (error.find("cannot redefine existing table") != std::string_view::npos)
    return "; it is there twice: put these keys where it is first";
  return std::string(quotes_hint(error));
}

}  // namespace

Value parse_toml(const std::string& text, const std::string& file, Errors& errors) {
  std::int64_t line = 0;
  if (too_many_dots(text, line)) {
    errors.add({file, line, 1}, fmt::format("more than {} dots in one line; break it into several", kMostDotsPerLine));
    return {};
  }
  try {
    const toml::table table = toml::parse(text);
    return convert(table, {file, 1, 1});
  } catch (const toml::parse_error& error) {
    const toml::source_region& source = error.source();
    errors.add({file, source.begin.line, source.begin.column},
               fmt::format("{}{}", error.description(), remedy(error.description(), text)));
    return {};
  }
}

Value parse_toml_value(std::string_view text, const Place& place) {
  Errors errors;
  Value table = parse_toml(fmt::format("value = {}", text), place.file, errors);
  if (errors.any() || table.table.size() != 1) return text_value(std::string(text), place);
  Value value = std::move(table.table.front().value);
  const auto move_to = [&](auto&& self, Value& v) -> void {
    v.place = place;
    for (Value& child : v.list) self(self, child);
    for (Entry& entry : v.table) {
      entry.place = place;
      self(self, entry.value);
    }
  };
  move_to(move_to, value);
  return value;
}

std::string print_toml(const Value& table) {
  std::ostringstream out;
  out << table_of(table) << '\n';
  return out.str();
}

}  // namespace evenstep::internal
