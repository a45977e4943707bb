#include "faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "check.h"
#include "evenstep/format/reader.h"
#include "evenstep/text/suggest.h"

namespace evenstep::internal {
namespace {

constexpr std::array kOfTiming{
    "changes", "hitch", "spikes", "preemption", "regimes", "dropped_visualization", "merged_visualization"};
constexpr std::array kOfDevice{"faults", "unplug", "events", "evdev.meddled_at", "inverse3.uncalibrated_at"};

const Value* below(const Value& table, std::string_view path) {
  const std::size_t dot = path.find('.');
  const Value* found = table.is(Value::Kind::table) ? table.find(path.substr(0, dot)) : nullptr;
  return found == nullptr || dot == std::string_view::npos ? found : below(*found, path.substr(dot + 1));
}

std::vector<std::string> names_off(const Value& document) {
  std::vector<std::string> names;
  const Value* off = below(document, "run.faults_off");
  if (off == nullptr || !off->is(Value::Kind::list)) return names;
  for (const Value& name : off->list) {
    if (name.is(Value::Kind::text)) names.push_back(name.text);
  }
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// `off`: the names of entries that are not in the lists any more, or empty.
std::vector<FaultPlace> places_of(const Value& document, const std::vector<std::string>& off) {
  std::vector<FaultPlace> places;
  const Value* timing = document.find("timing");
  for (const char* key : kOfTiming) {
    if (timing != nullptr && below(*timing, key) != nullptr)
      places.push_back({fmt::format("timing.{}", key), key, 0, 0, true});
  }
  const Value* devices = document.find("device");
  for (std::size_t d = 0; devices != nullptr && d < devices->list.size(); ++d) {
    const Value* name = below(devices->list[d], "name");
    const std::string device = name != nullptr && name->is(Value::Kind::text) ? name->text : fmt::format("{}", d);
    for (const std::string key : kOfDevice) {
      const Value* there = below(devices->list[d], key);
      if (there == nullptr) continue;
      const std::string path = fmt::format("device.{}.{}", device, key);
      if (key != "faults") {
        places.push_back({path, key, d, 0, false});
        continue;
      }
      for (std::size_t entry = 0, written = 0; entry < there->list.size(); ++written) {
        const std::string one = fmt::format("{}.{}", path, written);
        if (!contains(off, one)) places.push_back({one, key, d, entry++, false});
      }
    }
  }
  return places;
}

void erase(Value& table, std::string_view path) {
  const std::size_t dot = path.find('.');
  Value* inner = dot == std::string_view::npos ? nullptr : table.find(path.substr(0, dot));
  if (inner != nullptr) return erase(*inner, path.substr(dot + 1));
  std::erase_if(table.table, [&](const Entry& entry) { return entry.key == path; });
}

}  // namespace

std::vector<FaultPlace> fault_places(const Value& document) { return places_of(document, names_off(document)); }

void switch_off_faults(Value& document, Errors& errors) {
  const std::vector<std::string> off = names_off(document);
  if (off.empty()) return;
  const std::vector<FaultPlace> places = places_of(document, {});
  std::vector<std::string_view> known;
  for (const FaultPlace& place : places) known.push_back(place.name);
  for (const Value& name : below(document, "run.faults_off")->list) {
    if (!name.is(Value::Kind::text) || std::find(known.begin(), known.end(), name.text) != known.end()) continue;
    errors.add(name.place, fmt::format("'faults_off': there is no fault '{}'{}", name.text,
                                       known.empty() ? "; this scenario has none" : suggestion(name.text, known)));
  }
  for (auto place = places.rbegin(); place != places.rend(); ++place) {  // entries of a list from its end on
    if (!contains(off, place->name)) continue;
    if (place->of_timing) {
      erase(*document.find("timing"), place->key);
      continue;
    }
    Value& device = document.find("device")->list[place->device];
    if (place->key != "faults") {
      erase(device, place->key);
      if (place->key == "unplug") erase(device, "returns");  // without it nothing returns
      continue;
    }
    std::vector<Value>& entries = device.find("faults")->list;
    entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(place->entry));
  }
}

void erase_faults_after(Value& document, Duration run) {
  Errors none;
  const auto late = [&](const Value& value, const char* table_name, const char* key) {
    const Table table(&value, table_name, value.place);
    return table.has(key) && table.span(key, NominalUnits{}, none) >= run;
  };
  Value* devices = document.find("device");
  for (std::size_t d = 0; devices != nullptr && d < devices->list.size(); ++d) {
    Value& device = devices->list[d];
    if (late(device, "device", "unplug")) {
      erase(device, "unplug");
      erase(device, "returns");
    }
    for (const std::string list : {"faults", "events"}) {
      if (Value* const entries = device.find(list))
        std::erase_if(entries->list, [&](const Value& one) { return late(one, ("device." + list).c_str(), "at"); });
    }
    for (const auto& [table, key] : {std::pair("evdev", "meddled_at"), std::pair("inverse3", "uncalibrated_at")}) {
      const Value* const there = device.find(table);
      if (there != nullptr && late(*there, table, key)) erase(device, fmt::format("{}.{}", table, key));
    }
  }
}

}  // namespace evenstep::internal
