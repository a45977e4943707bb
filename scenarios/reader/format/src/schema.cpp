// JSON Schema for editors, from the field table. Draft-04: the newest that Taplo reads.
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <cmath>

#include "evenstep/format/fields.h"
#include "evenstep/format/scenario.h"
#include "evenstep/reports/json.h"
#include "evenstep/text/units.h"

namespace evenstep {
namespace internal {
namespace {

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

Json numeric(const Field& field, const char* type) {
  Json out = {{"type", type}};
  if (std::isfinite(field.range.least)) out["minimum"] = json_number(field.range.least);
  if (field.range.above_least) out["exclusiveMinimum"] = true;
  if (std::isfinite(field.range.most)) out["maximum"] = json_number(field.range.most);
  return out;
}

Json pattern(const std::string& text) { return {{"type", "string"}, {"pattern", text}}; }

/// What a table's schema depends on besides the table's name.
struct Making {
  bool whole;                ///< the table stands for itself
  const Registry& registry;  ///< whose names are those of foreign parts
};

Json table_schema(std::string_view table, const Making& making);

/// The registered names that this key can have; empty if it is not the name of a foreign part, or none is registered.
std::vector<std::string> registered_names(const Field& field, const Registry& registry) {
  std::vector<std::string> names;
  const auto put = [&](std::string_view table, const auto& parts) {
    if (field.table != table || (field.key != "name" && !(table == "scene" && field.key == "kind"))) return;
    for (const auto& [name, make] : parts) names.push_back(name);
  };
  put("scene", registry.solvers());
  put("device.foreign", registry.devices());
  put("remap.foreign", registry.maps());
  put("timing.foreign", registry.timings());
  put("case.foreign", registry.solvers());
  return names;
}

/// Whether a table of this field stands for itself. One in a list does, except for [[device]], which is merged by its name
/// with that of a file named in `extends`. Any other table may be completed by such a file, or may itself be only a part.
bool is_whole(const Field& field) { return field.shape != Shape::one && field.key != "device"; }

/// The forms of one element of the field, which belongs to this table.
Json alternatives(const Field& field, const Making& making) {
  constexpr const char* kTime = "(ns|us|ms|s|min|h)";
  Json out = Json::array();
  if (field.forms & kWord) out.push_back({{"enum", split_words(field.words)}});
  if (field.forms & kBoolean) out.push_back({{"type", "boolean"}});
  if (field.forms & kInteger) out.push_back(numeric(field, "integer"));
  if (field.forms & kNumber) out.push_back(numeric(field, "number"));
  if (field.forms & kLimit) out.push_back({{"type", "number"}});
  if (const auto names = registered_names(field, making.registry); !names.empty())
    out.push_back({{"enum", names}});
  else if (field.forms & (kText | kFile))
    out.push_back({{"type", "string"}});
  if (field.forms & kJitter) out.push_back(pattern("^(lognormal|uniform) [0-9.]+ *%$"));
  if (field.forms & kPareto) out.push_back(pattern(fmt::format("^pareto [0-9.]+ *{} cap [0-9.]+ *{}$", kTime, kTime)));
  if (field.forms & kSegments) out.push_back(pattern("^[0-9.]+ *segments?$"));
  if (field.forms & kSmooth) out.push_back(pattern(fmt::format("^smooth [0-9.]+ *{}$", kTime)));
  if (field.forms & kWork) out.push_back(pattern(fmt::format("^(render|burn) [0-9.]+ *{}$", kTime)));
  if (field.forms & (kDuration | kSpan | kRate | kQuantity | kLimit)) out.push_back(pattern(unit_pattern(field)));
  if (field.forms & kAnything) out.push_back(Json::object());
  if (field.forms & kOptions) out.push_back({{"type", "object"}});
  if (field.forms & kTable) out.push_back(table_schema(subtable(field), {making.whole || is_whole(field), making.registry}));
  return out;
}

Json any_of(Json choices) {
  if (choices.size() == 1) return choices.front();
  return {{"anyOf", std::move(choices)}};
}

Json shaped(const Field& field, const Making& making) {
  Json one = any_of(alternatives(field, making));
  switch (field.shape) {
    case Shape::one:
      break;
    case Shape::list:
      return {{"type", "array"}, {"items", std::move(one)}};
    case Shape::one_or_list: {
      Json list = {{"type", "array"}, {"minItems", 1}, {"items", one}};
      return any_of(Json::array({std::move(one), std::move(list)}));
    }
    case Shape::three:
      return {{"type", "array"}, {"minItems", 3}, {"maxItems", 3}, {"items", std::move(one)}};
  }
  return one;
}

/// All rows of a key (one per kind) as one property: first the hover text, then the allowed values.
Json property(std::string_view table, std::string_view key, const Making& making) {
  Json schemas = Json::array();
  std::vector<std::string> meanings;
  for (const Field& field : fields()) {
    if (field.table != table || field.key != key) continue;
    const Json schema = shaped(field, making);
    if (std::find(schemas.begin(), schemas.end(), schema) == schemas.end()) schemas.push_back(schema);
    meanings.push_back(std::string(field.meaning) +
                       (field.default_toml.empty() ? "" : fmt::format(" Default: {}.", field.default_toml)));
  }
  return {{"description", fmt::format("{}", fmt::join(meanings, " | "))},
          {"allOf", Json::array({any_of(std::move(schemas))})}};
}

/// The schema allows the keys of all kinds, and requires keys only in tables that stand for themselves; `evenstep check`
/// reports the rest.
Json table_schema(std::string_view table, const Making& making) {
  Json properties = Json::object(), required = Json::array(), others = false;
  std::string_view last;
  for (const Field& field : fields()) {
    if (field.table != table) continue;
    if (field.key == "*") {
      others = shaped(field, making);
      continue;
    }
    if (field.key != last) properties[std::string(field.key)] = property(table, field.key, making);
    last = field.key;
    if (field.required && field.kinds.empty() && (making.whole || (table.empty() && field.key == "format")))
      required.push_back(field.key);
  }
  Json out = {{"type", "object"}, {"additionalProperties", std::move(others)}};
  if (!required.empty()) out["required"] = std::move(required);
  out["properties"] = std::move(properties);
  return out;
}

}  // namespace
}  // namespace internal

std::string scenario_schema(const Registry& registry) {
  const Json schema = {{"$schema", "http://json-schema.org/draft-04/schema#"},
                       {"title", "evenstep scenario"},
                       {"allOf", Json::array({internal::table_schema("", {false, registry})})}};
  return schema.dump(1) + '\n';
}

}  // namespace evenstep
