#include "document.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/format/fields.h"
#include "evenstep/format/load.h"
#include "evenstep/format/reader.h"
#include "evenstep/text/units.h"

namespace evenstep::internal {
namespace {

const Place kNowhere{"", 0, 0};

Value text_of_ns(std::int64_t ns) { return text_value(fmt::format("{} ns", ns), kNowhere); }

bool is_nominal(std::string_view text) {
  const Unit* unit = find_unit(split_number(text).unit);
  return unit != nullptr && unit->dimension == Dimension::time && unit->kind != UnitKind::plain;
}

void put(Value& table, std::string_view key, Value value) {
  if (Value* there = table.find(key))
    *there = std::move(value);
  else
    table.table.push_back({std::string(key), kNowhere, std::move(value)});
}

void drop(Value& table, std::string_view key) {
  std::erase_if(table.table, [&](const Entry& entry) { return entry.key == key; });
}

/// The table with this key; it is made if it does not exist.
Value& table_at(Value& document, std::string_view key) {
  if (document.find(key) == nullptr) put(document, key, parse_toml_value("{}", kNowhere));
  return *document.find(key);
}

/// Makes the text of a key independent of the nominal times, whatever forms it may have.
void fix_text(std::uint32_t forms, Value& value, const NominalUnits& nominal) {
  if (!value.is(Value::Kind::text) || !is_nominal(value.text)) return;
  if (forms & kSpan) {
    value = text_of_ns(parse_duration(value.text, nominal)->ns);
  } else if (forms & kLimit) {
    const Limit limit = *parse_limit(value.text);
    value = text_value(fmt::format("{} s", *in_base(limit, "s", 0, nominal)), kNowhere);
  }
}

void fix_times(Value& table, const std::string& name, const NominalUnits& nominal) {
  for (Entry& entry : table.table) {
    std::uint32_t forms = 0;
    for (const Field& field : fields()) {
      if (field.table == name && field.key == entry.key) forms |= field.forms;
    }
    const std::string below = name.empty() ? entry.key : name + "." + entry.key;
    const auto fix = [&](Value& value) {
      if (value.is(Value::Kind::table))
        fix_times(value, below, nominal);
      else
        fix_text(forms, value, nominal);
    };
    if (entry.value.is(Value::Kind::list)) {
      for (Value& one : entry.value.list) fix(one);
    } else {
      fix(entry.value);
    }
  }
}

Value strategy_names(const std::vector<StrategyKind>& strategies) {
  Value names = parse_toml_value("[]", kNowhere);
  for (const StrategyKind kind : strategies) names.list.push_back(text_value(name_of(kind), kNowhere));
  return names;
}

/// The default window of a moving average is a segment, so it is written out.
void fix_filter_window(Value& document, const Scenario& scenario) {
  Value* remap = document.find("remap");
  Value* filter = remap == nullptr ? nullptr : remap->find("filter");
  const Value* kind = filter == nullptr ? nullptr : filter->find("kind");
  if (kind != nullptr && kind->text == "moving-average" && filter->find("window") == nullptr)
    put(*filter, "window", text_of_ns(scenario.remap.filter_window.ns));
}

}  // namespace

Value fixed_document(Value document, const Scenario& scenario, const std::vector<StrategyKind>& strategies,
                     std::size_t expectation) {
  Errors known;  // stays empty: the document was read without errors
  switch_off_faults(document, known);
  drop(table_at(document, "run"), "faults_off");
  for (const std::string_view key : {"sweep", "sometimes", "study", "expect_stop", "timing"}) drop(document, key);
  fix_times(document, "", scenario.nominal);
  fix_filter_window(document, scenario);
  Value& expect = *document.find("expect");
  Value kept = std::move(expect.list[expectation]);
  for (const std::string_view key : {"confidence", "seeds"}) drop(kept, key);  // a recording has no further seeds
  expect.list.assign(1, std::move(kept));
  drop(table_at(document, "run"), "interrupt");
  put(table_at(document, "run"), "strategies", strategy_names(strategies));
  const Rate rate = scenario.scene.step_rate;
  const std::string step_rate = rate.den == 1 ? fmt::format("{} Hz", rate.num) : fmt::format("{}/{} Hz", rate.num, rate.den);
  put(*document.find("scene"), "step_size", text_value(step_rate, kNowhere));
  return document;
}

void set_timing(Value& document, const std::string& trace, Duration duration) {
  Value timing = parse_toml_value("{}", kNowhere);
  put(timing, "trace", text_value(trace, kNowhere));
  put(document, "timing", std::move(timing));
  put(table_at(document, "run"), "duration", text_of_ns(duration.ns));
  erase_faults_after(document, duration);
}

}  // namespace evenstep::internal
