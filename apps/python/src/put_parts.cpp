// A scenario's table with Python parts in the place of others.

#include <algorithm>
#include <set>

#include "evenstep/format/reader.h"
#include "evenstep/format/registry.h"
#include "parts.h"

namespace evenstep::python {
namespace {

using internal::Value;

constexpr const char* kName = "python";  // of a part that the scenario does not name

Place place_of(const char* kind) { return {std::string("the argument ") + kind + "="}; }

/// The table's entry, which is made if it is not there.
Value& entry(Value& table, const char* key, const Place& place) {
  if (Value* const found = table.find(key)) return *found;
  Value value;
  value.place = place;
  table.table.push_back({key, place, value});
  return table.table.back().value;
}

void put_text(Value& table, const char* key, const char* text, const Place& place) {
  entry(table, key, place) = internal::text_value(text, place);
}

/// The name that the table `foreign` of this table has; empty if there is none.
std::string named(const Value* table, const char* within = "foreign") {
  const Value* const foreign = table != nullptr && *within ? table->find(within) : table;
  const Value* const name = foreign != nullptr && foreign->is(Value::Kind::table) ? foreign->find("name") : nullptr;
  return name != nullptr && name->is(Value::Kind::text) ? name->text : "";
}

/// A table with nothing but a name.
Value named_table(const Place& place) {
  Value table;
  table.place = place;
  put_text(table, "name", kName, place);
  return table;
}

void erase(Value& table, const std::set<std::string>& but) {
  std::erase_if(table.table, [&](const internal::Entry& one) { return !but.contains(one.key); });
}

std::string put_solver(Value& document) {
  const Place place = place_of("solver");
  Value& scene = entry(document, "scene", place);
  const Value* const kind = scene.find("kind");
  if (const std::string name = named(&scene, ""); !name.empty() && (!kind || kind->text == "foreign")) return name;
  erase(scene, {"step_size"});
  put_text(scene, "kind", "foreign", place);
  put_text(scene, "name", kName, place);
  if (Value* const devices = document.find("device")) {
    for (Value& device : devices->list)
      std::erase_if(device.table, [](const internal::Entry& one) { return one.key == "grab"; });
  }
  return kName;
}

std::string put_device(Value& document) {
  const Place place = place_of("device");
  Value* const devices = document.find("device");
  if (devices == nullptr) return kName;  // the reader says that there is none
  for (const Value& device : devices->list)
    if (const std::string name = named(&device); !name.empty()) return name;
  for (Value& device : devices->list) {
    put_text(device, "driver", "foreign", place);
    entry(device, "foreign", place) = named_table(place);
  }
  return kName;
}

std::string put_map(Value& document) {
  const Place place = place_of("map");
  Value& remap = entry(document, "remap", place);
  std::string name = named(&remap);
  if (name.empty()) {
    entry(remap, "foreign", place) = named_table(place);
    name = kName;
  }
  Value* const run = document.find("run");
  Value* const strategies = run != nullptr ? run->find("strategies") : nullptr;
  if (strategies == nullptr || !strategies->is(Value::Kind::list)) return name;
  std::vector<Value>& list = strategies->list;
  if (std::none_of(list.begin(), list.end(), [](const Value& strategy) { return strategy.text == "foreign"; }))
    list.push_back(internal::text_value("foreign", place));
  return name;
}

std::string put_timing(Value& document) {
  const Place place = place_of("timing");
  Value& timing = entry(document, "timing", place);
  if (const std::string name = named(&timing); !name.empty()) return name;
  erase(timing, {});
  entry(timing, "foreign", place) = named_table(place);
  return kName;
}

}  // namespace

WithParts read_with_parts(const std::string& file, const std::vector<std::string>& set, std::optional<std::uint64_t> seed,
                          const py::dict& parts) {
  internal::Errors errors;
  Value document = internal::load_with_overrides(file, {set, seed}, errors);
  if (errors.any()) return {Failure(errors.sorted(file))};
  py::dict by_name;
  for (const auto& [kind, put] : {std::pair{"solver", &put_solver}, std::pair{"device", &put_device},
                                  std::pair{"map", &put_map}, std::pair{"timing", &put_timing}}) {
    if (!parts.contains(kind)) continue;
    const py::object given = parts[kind];
    if (py::isinstance<py::dict>(given)) {
      by_name[kind] = given;
    } else {
      py::dict one;
      one[py::str(put(document))] = given;
      by_name[kind] = one;
    }
  }
  WithParts with{Failure(std::vector<Diagnostic>{})};
  const Registry registry = registry_of(by_name, with.error);
  const py::gil_scoped_release without_gil;  // a timing source is asked, and a part of C opened, while this reads
  with.scenario = internal::read_document(std::move(document), file, registry, false);
  return with;
}

}  // namespace evenstep::python
