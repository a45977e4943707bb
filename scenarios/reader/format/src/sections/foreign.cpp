// Parts that are not evenstep's own: a name, or a file, and options that are passed on as JSON.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "evenstep/format/load.h"
#include "evenstep/text/suggest.h"
#include "src/field_rows.h"
#include "src/sections.h"

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
           .meaning = "The name under which the program has registered it. Write this or `library`.",
           .kinds = kinds,
           .example = "\"mine\""},
          {.table = table,
           .key = "library",
           .forms = kFile,
           .meaning = "The shared object that contains it (docs/parts/extending.md). Reading the scenario opens it.",
           .kinds = kinds,
           .example = "\"libmine.so\""},
          {.table = table,
           .key = "options",
           .forms = kOptions,
           .default_toml = "{}",
           .meaning = "Passed on to it as JSON; evenstep reads nothing of it.",
           .kinds = kinds}};
}

std::vector<Field> library_rows(std::string_view table, std::string_view kinds) {
  return {{.table = table,
           .key = "library",
           .forms = kFile,
           .meaning = "Short for foreign = { library = ... }.",
           .kinds = kinds,
           .example = "\"libmine.so\""},
          {.table = table,
           .key = "options",
           .forms = kOptions,
           .meaning = "With `library`: passed on to it, as the options of `foreign` are.",
           .kinds = kinds}};
}

Foreign read_foreign(const ScenarioReading& reading, const Table& table, bool must_say_which) {
  Foreign part;
  part.options = json_of(table.at("options")).dump();
  part.seed = reading.scenario.seed;
  if (table.has("name")) part.name = table.text("name");
  if (table.has("library")) part.library = path_from(table.at("library"));
  part.place = table.place(table.has("library") ? "library" : "name");
  if (table.has("name") && table.has("library"))
    reading.errors.add(table.place("name"), "'name' does not go with 'library', which has its own; remove one of them");
  if (must_say_which && !table.has("name") && !table.has("library"))
    reading.errors.add(part.place, fmt::format("{} has no 'name'; write name = \"mine\", or library = \"libmine.so\"",
                                               title(table.name())));
  return part;
}

Library library_of(const char* kind, Foreign& part, Errors& errors) {
  Result<Library, std::string> library = open_library(part.library);
  if (!library) {
    errors.add(part.place, "'library': " + library.error());
    return {};
  }
  part.name = library->name;
  for (const auto& [has, of] : {std::pair{bool(library->solver), "solver"}, std::pair{bool(library->device), "driver"},
                                std::pair{bool(library->map), "map"}, std::pair{bool(library->timing), "timing source"}}) {
    if (std::string_view(of) == kind && !has) add_missing(kind, part, {}, errors);
  }
  return *std::move(library);
}

void add_missing(const char* kind, const Foreign& part, const std::vector<std::string_view>& known, Errors& errors) {
  if (!part.library.empty())
    return errors.add(part.place, fmt::format("'library': '{}' ('{}') has no {}", part.library, part.name, kind));
  if (part.name.empty()) return;  // it has an error already
  errors.add(part.place,
             fmt::format("the {} '{}' is not registered{}", kind, part.name,
                         known.empty() ? "; this needs a program that registers it" : suggestion(part.name, known)));
}

}  // namespace evenstep::internal
