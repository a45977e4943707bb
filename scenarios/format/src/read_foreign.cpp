// Parts that are registered by the program: a name, and options that are passed on as JSON.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evenstep/text/suggest.h"
#include "field_rows.h"
#include "sections.h"

namespace evenstep::internal {
namespace {

nlohmann::json json_of(const Value& value) {
  switch (value.kind) {
    case Value::Kind::boolean:
      return value.boolean;
    case Value::Kind::integer:
      return value.integer;
    case Value::Kind::number:
      return value.number;
    case Value::Kind::text:
    case Value::Kind::date:  // refused by the check
      return value.text;
    case Value::Kind::list: {
      nlohmann::json list = nlohmann::json::array();
      for (const Value& one : value.list) list.push_back(json_of(one));
      return list;
    }
    case Value::Kind::table:
      break;
  }
  nlohmann::json table = nlohmann::json::object();
  for (const Entry& entry : value.table) table[entry.key] = json_of(entry.value);
  return table;
}

}  // namespace

std::vector<Field> foreign_rows(std::string_view table, std::string_view kinds) {
  return {{.table = table,
           .key = "name",
           .forms = kText,
           .meaning = "The name it was registered under.",
           .kinds = kinds,
           .required = true,
           .example = "\"mine\""},
          {.table = table,
           .key = "options",
           .forms = kOptions,
           .default_toml = "{}",
           .meaning = "Passed on to it as JSON; evenstep reads nothing of it.",
           .kinds = kinds}};
}

Foreign read_foreign(const Table& table) {
  return {table.text("name"), json_of(table.at("options")).dump(), table.place("name")};
}

void add_unregistered(const char* kind, const Foreign& part, const std::vector<std::string_view>& known, Errors& errors) {
  errors.add(part.place,
             fmt::format("the {} '{}' is not registered{}", kind, part.name,
                         known.empty() ? "; this needs a program that registers it" : suggestion(part.name, known)));
}

}  // namespace evenstep::internal
