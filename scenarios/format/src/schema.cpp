// JSON Schema for editors, from the field table. Draft-04: the newest that Taplo reads.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/format/scenario.h"
#include "evenstep/format/fields.h"
#include "evenstep/text/units.h"

namespace evenstep {
namespace internal {
namespace {

/// A JSON string.
std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

/// A pattern for texts such as "11.1 ms"; the blank is optional, and units that are words may have a plural.
std::string unit_pattern(const Field& field) {
  std::vector<std::string> names;
  for (const Unit& unit : units()) {
    const bool time = (field.forms & (kDuration | kSpan)) && unit.dimension == Dimension::time &&
                      (unit.kind == UnitKind::plain || (field.forms & kSpan));
    const bool rate = (field.forms & kRate) && unit.dimension == Dimension::rate;
    const bool quantity = (field.forms & kQuantity) && unit.dimension == field.dimension;
    const bool limit = (field.forms & kLimit) != 0;
    if (time || rate || quantity || limit) names.push_back(std::string(unit.name) + (unit.word ? "s?" : ""));
  }
  if (field.forms & kLimit) names.emplace_back("steps?");
  const bool bare = field.forms & kLimit;
  return fmt::format("^[+-]?[0-9.]+([eE][+-]?[0-9]+)?{} *({}){}$", field.forms & kRate ? "(/[0-9.]+)?" : "",
                     fmt::join(names, "|"), bare ? "?" : "");
}

std::string numeric(const Field& field, std::string_view type) {
  std::string out = fmt::format("{{\"type\": \"{}\"", type);
  if (std::isfinite(field.range.least)) out += fmt::format(", \"minimum\": {}", field.range.least);
  if (field.range.above_least) out += ", \"exclusiveMinimum\": true";
  if (std::isfinite(field.range.most)) out += fmt::format(", \"maximum\": {}", field.range.most);
  return out + "}";
}

std::string table_schema(std::string_view table);

/// The forms of one element, as JSON schemas.
std::vector<std::string> alternatives(const Field& field) {
  std::vector<std::string> out;
  if (field.forms & kWord) {
    std::vector<std::string> words;
    for (const std::string_view word : split_words(field.words)) words.push_back(quoted(word));
    out.push_back(fmt::format("{{\"enum\": [{}]}}", fmt::join(words, ", ")));
  }
  if (field.forms & kBoolean) out.emplace_back("{\"type\": \"boolean\"}");
  if (field.forms & kInteger) out.push_back(numeric(field, "integer"));
  if (field.forms & kNumber) out.push_back(numeric(field, "number"));
  if (field.forms & kLimit) out.emplace_back("{\"type\": \"number\"}");
  if (field.forms & (kText | kFile)) out.emplace_back("{\"type\": \"string\"}");
  if (field.forms & kLognormal) out.emplace_back("{\"type\": \"string\", \"pattern\": \"^lognormal [0-9.]+ *%$\"}");
  if (field.forms & kPareto) {
    out.emplace_back(
        "{\"type\": \"string\", \"pattern\": \"^pareto [0-9.]+ *(ns|us|ms|s|min|h) cap [0-9.]+ *(ns|us|ms|s|min|h)$\"}");
  }
  if (field.forms & kSegments) out.emplace_back("{\"type\": \"string\", \"pattern\": \"^[0-9.]+ *segments?$\"}");
  if (field.forms & kSmooth)
    out.emplace_back("{\"type\": \"string\", \"pattern\": \"^smooth [0-9.]+ *(ns|us|ms|s|min|h)$\"}");
  if (field.forms & (kDuration | kSpan | kRate | kQuantity | kLimit)) {
    out.push_back(fmt::format("{{\"type\": \"string\", \"pattern\": {}}}", quoted(unit_pattern(field))));
  }
  if (field.forms & kAnything) out.emplace_back("{}");
  if (field.forms & kTable) out.push_back(table_schema(subtable(field)));
  return out;
}

std::string any_of(const std::vector<std::string>& choices) {
  return choices.size() == 1 ? choices.front() : fmt::format("{{\"anyOf\": [{}]}}", fmt::join(choices, ", "));
}

std::string shaped(const Field& field) {
  const std::string one = any_of(alternatives(field));
  switch (field.shape) {
    case Shape::one:
      return one;
    case Shape::list:
      return fmt::format("{{\"type\": \"array\", \"items\": {}}}", one);
    case Shape::one_or_list:
      return fmt::format("{{\"anyOf\": [{}, {{\"type\": \"array\", \"minItems\": 1, \"items\": {}}}]}}", one, one);
    case Shape::three:
      return fmt::format("{{\"type\": \"array\", \"minItems\": 3, \"maxItems\": 3, \"items\": {}}}", one);
  }
  return one;
}

/// All rows of a key (one per kind) as one property: first the hover text, then the allowed values.
std::string property(std::string_view table, std::string_view key) {
  std::vector<std::string> schemas, meanings;
  for (const Field& field : fields()) {
    if (field.table != table || field.key != key) continue;
    const std::string schema = shaped(field);
    if (std::find(schemas.begin(), schemas.end(), schema) == schemas.end()) schemas.push_back(schema);
    meanings.push_back(std::string(field.meaning) +
                       (field.default_toml.empty() ? "" : fmt::format(" Default: {}.", field.default_toml)));
  }
  return fmt::format("{}: {{\"description\": {}, \"allOf\": [{}]}}", quoted(key),
                     quoted(fmt::format("{}", fmt::join(meanings, " | "))), any_of(schemas));
}

/// The schema allows keys of other kinds; `evenstep check` reports them.
std::string table_schema(std::string_view table) {
  std::vector<std::string> properties, required;
  std::string others = "false";
  std::string_view last;
  for (const Field& field : fields()) {
    if (field.table != table) continue;
    if (field.key == "*") {
      others = shaped(field);
      continue;
    }
    if (field.key != last) properties.push_back(property(table, field.key));
    last = field.key;
    // A base file need not be complete, so at the top only those keys are required that every file must have.
    if (field.required && field.kinds.empty() && (!table.empty() || field.key == "format"))
      required.push_back(quoted(field.key));
  }
  const std::string must = required.empty() ? "" : fmt::format(", \"required\": [{}]", fmt::join(required, ", "));
  return fmt::format("{{\"type\": \"object\", \"additionalProperties\": {}{}, \"properties\": {{\n{}\n}}}}", others, must,
                     fmt::join(properties, ",\n"));
}

}  // namespace
}  // namespace internal

std::string scenario_schema() {
  return fmt::format(
      "{{\"$schema\": \"http://json-schema.org/draft-04/schema#\", \"title\": \"evenstep scenario\", \"allOf\": [{}]}}\n",
      internal::table_schema(""));
}

}  // namespace evenstep
