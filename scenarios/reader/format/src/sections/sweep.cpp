// [sweep]
#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

#include "evenstep/format/load.h"
#include "evenstep/text/suggest.h"
#include "evenstep/text/units.h"
#include "src/field_rows.h"
#include "src/sections.h"

namespace evenstep::internal {
namespace {

/// Parses "0..30000", whose end is excluded; false if the text has another form.
bool parse_span(const std::string& text, std::uint64_t& first, std::uint64_t& end) {
  const std::size_t dots = text.find("..");
  if (dots == std::string::npos) return false;
  const auto whole = [&](std::size_t from, std::size_t to, std::uint64_t& out) {
    const auto [at, error] = std::from_chars(text.data() + from, text.data() + to, out);
    return error == std::errc{} && at == text.data() + to;
  };
  return whole(0, dots, first) && whole(dots + 2, text.size(), end) && first < end && end <= INT64_MAX;
}

void append_seeds(const Value& value, std::vector<std::uint64_t>& seeds, Errors& errors) {
  if (value.is(Value::Kind::integer)) {
    seeds.push_back(static_cast<std::uint64_t>(value.integer));
    return;
  }
  std::uint64_t first = 0, end = 0;
  if (!parse_span(value.text, first, end)) {
    errors.add(value.place, fmt::format("'seeds': \"{}\" must be two whole numbers, the first one below the other, such as "
                                        "\"0..30000\" for 0 to 29999",
                                        value.text));
  } else if (seeds.size() + (end - first) > static_cast<std::uint64_t>(kMostSweepPoints)) {
    errors.add(value.place, fmt::format("'seeds': with \"{}\" there are more than {}", value.text, kMostSweepPoints));
  } else {
    for (std::uint64_t seed = first; seed < end; ++seed) seeds.push_back(seed);
  }
}

std::vector<std::uint64_t> read_seeds(const Table& sweep, std::uint64_t of_run, Errors& errors) {
  if (!sweep.has("seeds")) return {of_run};
  const Value given = sweep.at("seeds");
  std::vector<std::uint64_t> seeds;
  if (given.is(Value::Kind::list)) {
    for (const Value& one : given.list) append_seeds(one, seeds, errors);
  } else {
    append_seeds(given, seeds, errors);
  }
  std::vector<std::uint64_t> sorted = seeds;
  std::sort(sorted.begin(), sorted.end());
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end()) errors.add(given.place, fmt::format("'seeds': {} is there twice", *twice));
  return seeds;
}

/// A value as TOML. An axis cannot have tables as values, and no key accepts a date.
std::string toml_text(const Value& value) {
  if (value.is(Value::Kind::list)) {
    std::vector<std::string> parts;
    for (const Value& one : value.list) parts.push_back(toml_text(one));
    return fmt::format("[{}]", fmt::join(parts, ", "));
  }
  if (!value.is(Value::Kind::text)) return as_written(value);
  std::string out = "\"";
  for (const char c : value.text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

/// A value that consists of a number and its unit.
struct Measure {
  double number = 0;
  std::string unit;
  bool whole = false;  ///< written as a whole number without a unit
};
std::optional<Measure> measure_of(const Value& value) {
  if (value.is(Value::Kind::integer)) return Measure{static_cast<double>(value.integer), "", true};
  if (value.is(Value::Kind::number)) return Measure{value.number, "", false};
  if (!value.is(Value::Kind::text)) return std::nullopt;
  const Result<Limit> limit = parse_limit(value.text);
  if (!limit) return std::nullopt;
  return Measure{limit->number, limit->unit, false};
}

/// Compares two values in a common unit; empty if there is none ("8 segments" and "1 ms").
std::optional<std::partial_ordering> compare(const Measure& a, const Measure& b) {
  if (a.unit == b.unit) return a.number <=> b.number;
  const Unit *of_a = find_unit(a.unit), *of_b = find_unit(b.unit);
  if (of_a == nullptr || of_b == nullptr) return std::nullopt;
  if (of_a->dimension != of_b->dimension || of_a->kind != of_b->kind) return std::nullopt;
  // A nominal time such as "8 segments" and "8 segment" has no length here, and needs none.
  if (of_a->kind != UnitKind::plain) return a.number <=> b.number;
  const std::string_view base = info(of_a->dimension).base;
  return *in_base({a.number, a.unit}, base, 0, {}) <=> *in_base({b.number, b.unit}, base, 0, {});
}

/// The same text for values of an axis that are equal: the number in the base unit if it has a unit with a fixed size.
std::string in_common_unit(const std::string& text, const Place& place) {
  const std::optional<Measure> measure = measure_of(parse_toml_value(text, place));
  if (!measure) return text;
  const bool bare = measure->unit.empty();  // 1, 1.0 and, where a ratio is meant, "100 %"
  const Unit* unit = bare ? nullptr : find_unit(measure->unit);
  if (unit == nullptr) return fmt::format("{} {}", measure->number, bare ? info(Dimension::ratio).base : measure->unit);
  if (unit->kind != UnitKind::plain) return fmt::format("{} {}", measure->number, unit->name);
  const DimensionInfo& of_unit = info(unit->dimension);
  return fmt::format("{} {}", *in_base({measure->number, measure->unit}, of_unit.base, 0, {}), of_unit.base);
}

/// The number of decimals with which a number in this unit is a whole number of nanoseconds; -1 if the unit is not a time
/// with a fixed length.
int decimals_of_ns(const std::string& name) {
  const Unit* unit = find_unit(name);
  if (unit == nullptr || unit->dimension != Dimension::time || unit->kind != UnitKind::plain) return -1;
  return std::max(0, 9 + unit->exponent);
}

std::string plain_number(double number, int decimals) {
  std::string text = decimals < 0 ? fmt::format("{:.12g}", number) : fmt::format("{:.{}f}", number, decimals);
  if (decimals > 0) text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

/// Appends the values of a range with from, to and count; both ends as they are written.
void append_range(const Table& range, std::string_view path, std::vector<std::string>& values, Errors& errors) {
  const Measure from = *measure_of(range.at("from")), to = *measure_of(range.at("to"));
  const std::int64_t count = range.integer("count");
  if (from.unit != to.unit)
    return errors.add(range.place("to"), fmt::format("'{}': 'from' and 'to' must be in the same unit", path));
  if (!(from.number < to.number)) return errors.add(range.place("to"), fmt::format("'{}': 'to' must be above 'from'", path));
  const bool whole = from.whole && to.whole;
  if (whole && std::fmod(to.number - from.number, static_cast<double>(count - 1)) != 0) {
    return errors.add(range.place("count"),
                      fmt::format("'{}': {} whole numbers from {} to {} are not evenly spaced; write a "
                                  "list, or another count",
                                  path, count, from.number, to.number));
  }
  for (std::int64_t i = 0; i < count; ++i) {
    if (i == 0 || i == count - 1) {
      values.push_back(toml_text(range.at(i == 0 ? "from" : "to")));
      continue;
    }
    const double number = from.number + (to.number - from.number) * static_cast<double>(i) / static_cast<double>(count - 1);
    const std::string text = plain_number(number, decimals_of_ns(from.unit));
    values.push_back(from.unit.empty() ? text : fmt::format("\"{} {}\"", text, from.unit));
  }
}

/// Adds an error for each axis that sets a key of an earlier one, or one within or around it: one of the two would have no
/// effect, and its values would count as points of their own all the same.
void check_keys(const Value& document, const std::vector<SweepAxis>& grid, Errors& errors) {
  std::vector<std::string> keys;
  for (const SweepAxis& axis : grid) {
    keys.push_back(indexed_path(document, axis.path));
    for (std::size_t i = 0; i + 1 < keys.size(); ++i) {
      if (is_within(keys.back(), keys[i]) || is_within(keys[i], keys.back()))
        errors.add(axis.place,
                   fmt::format("'{}' sets what '{}' of this grid sets; remove one of them", axis.path, grid[i].path));
    }
  }
}

std::string refusal(std::string_view path) {
  if (path == "run.faults_off")
    return "'run.faults_off' cannot be part of a grid: what is switched off is another scenario; write two, or [sweep] "
           "swarm = true";
  if (path == "run.seed") return "seeds have a key of their own; write [sweep] seeds";
  for (const std::string_view word :
       {"extends", "expect_append", "format", "sweep", "sometimes", "study", "name", "because", "tags"}) {
    if (path == word || path.starts_with(std::string(word) + "."))
      return fmt::format("'{}' cannot be part of a grid: it is no part of a run", word);
  }
  return {};
}

/// Adds an error for each value that an earlier one equals, in whatever unit: its points would be run and counted twice.
void check_different(const SweepAxis& axis, Errors& errors) {
  std::map<std::string, std::string> seen;  // the value in the base unit, and as it is written first
  for (const std::string& text : axis.values) {
    const auto [first, is_new] = seen.emplace(in_common_unit(text, axis.place), text);
    if (is_new) continue;
    errors.add(axis.place, first->second == text
                               ? fmt::format("'{}': {} is there twice", axis.path, text)
                               : fmt::format("'{}': {} is there twice: it equals {}", axis.path, text, first->second));
  }
}

SweepAxis read_axis(const Entry& entry, Errors& errors) {
  SweepAxis axis{entry.key, {}, entry.place};
  if (const std::string error = refusal(axis.path); !error.empty()) {
    errors.add(entry.place, error);
    return axis;
  }
  const auto append = [&](const Value& one) {
    if (one.is(Value::Kind::table))
      append_range(Table(&one, "sweep.grid.*", one.place), axis.path, axis.values, errors);
    else
      axis.values.push_back(toml_text(one));
  };
  if (entry.value.is(Value::Kind::list)) {
    for (const Value& one : entry.value.list) append(one);
  } else {
    append(entry.value);
  }
  check_different(axis, errors);
  return axis;
}

/// The values of the axis as measures, or an error.
std::vector<Measure> rising_values(const SweepAxis& axis, Errors& errors) {
  std::vector<Measure> measures;
  for (const std::string& text : axis.values) {
    const std::optional<Measure> measure = measure_of(parse_toml_value(text, axis.place));
    const bool rises = measure && (measures.empty() || compare(measures.back(), *measure) == std::partial_ordering::less);
    if (!rises) {
      errors.add(axis.place, fmt::format("'{}': {} {}; [sweep.find] needs values that rise", axis.path, text,
                                         measure ? "does not come after the one before it" : "is no number with a unit"));
      return {};
    }
    measures.push_back(*measure);
  }
  return measures;
}

void read_gate(const Table& find, std::string_view key, const std::vector<Measure>& values, SweepFind& out, Errors& errors) {
  out.allowed = values.size();
  if (!find.has(key)) return;
  const Value written = find.at(key);
  out.gate = written.is(Value::Kind::text) ? written.text : as_written(written);
  const Measure gate = *measure_of(written);
  out.allowed = 0;
  for (const Measure& value : values) {
    const std::optional<std::partial_ordering> order = compare(value, gate);
    if (!order)
      return errors.add(find.place(key),
                        fmt::format("'{}': \"{}\" cannot be compared with the grid's values", key, out.gate));
    if (out.smallest ? *order <= 0 : *order >= 0) ++out.allowed;
  }
  if (out.allowed == 0)
    errors.add(find.place(key), fmt::format("'{}': no value of the grid is within \"{}\"", key, out.gate));
}

std::optional<SweepFind> read_find(const Table& find, const std::vector<SweepAxis>& grid, Errors& errors) {
  SweepFind out;
  out.smallest = find.has("smallest");
  if (out.smallest == find.has("largest")) {
    errors.add(find.place(""), "[sweep.find] needs 'smallest' or 'largest', one of the two");
    return std::nullopt;
  }
  const std::string_view key = out.smallest ? "smallest" : "largest", gate = out.smallest ? "at_most" : "at_least";
  const std::string_view other_gate = out.smallest ? "at_least" : "at_most";
  if (find.has(other_gate))
    errors.add(find.place(other_gate), fmt::format("'{}' does not go with '{}'; write '{}'", other_gate, key, gate));
  const std::string path = find.text(key);
  const auto axis = std::find_if(grid.begin(), grid.end(), [&](const SweepAxis& one) { return one.path == path; });
  if (axis == grid.end()) {
    std::vector<std::string_view> paths;
    for (const SweepAxis& one : grid) paths.push_back(one.path);
    errors.add(find.place(key), fmt::format("'{}': \"{}\" is no key of [sweep.grid]{}", key, path, suggestion(path, paths)));
    return std::nullopt;
  }
  out.axis = static_cast<std::size_t>(axis - grid.begin());
  read_gate(find, gate, rising_values(*axis, errors), out, errors);
  return out;
}

}  // namespace

void read_sweep(ScenarioReading& reading) {
  const Value* written = reading.document.find("sweep");
  if (written == nullptr || !reading.sound("sweep")) return;
  Errors& errors = reading.errors;
  const Table sweep = reading.section("sweep");
  SweepSpec spec;
  spec.seeds = read_seeds(sweep, reading.scenario.seed, errors);
  if (const Value* grid = written->find("grid")) {
    for (const Entry& entry : grid->table) spec.grid.push_back(read_axis(entry, errors));
  }
  check_keys(reading.document, spec.grid, errors);
  __int128 points = static_cast<__int128>(spec.seeds.size());
  for (const SweepAxis& axis : spec.grid)
    points = std::min<__int128>(points * static_cast<__int128>(axis.values.size()), INT64_MAX);
  if (points > kMostSweepPoints)
    errors.add(written->place, fmt::format("[sweep] has more than {} points; take fewer seeds or values", kMostSweepPoints));
  spec.keep_worst = static_cast<int>(sweep.integer("keep_worst"));
  spec.swarm = sweep.boolean("swarm");
  spec.swarm_place = sweep.place("swarm");
  if (sweep.has("stop_after")) spec.stop_after = sweep.integer("stop_after");
  if (sweep.has("find")) {
    spec.find = read_find(sweep.table("find"), spec.grid, errors);
    if (spec.stop_after)
      errors.add(sweep.place("stop_after"),
                 "'stop_after' does not go with [sweep.find], which must know every point; remove one");
  }
  reading.scenario.sweep = std::move(spec);
}

// A key is a few full lines.
// clang-format off
const std::vector<Field>& sweep_fields() {
  static const std::vector<Field> rows{
      {.table = "sweep", .key = "seeds", .forms = kText | kInteger, .shape = Shape::one_or_list,
       .meaning = "Values of [run] `seed`. `\"0..30000\"` is 30000 seeds, 0 to 29999. Default: that of [run].",
       .range = at_least(0), .example = "\"0..30000\""},
      {.table = "sweep", .key = "swarm", .forms = kBoolean, .default_toml = "false",
       .meaning = "Each seed switches off about half of the programmed faults, as [run] `faults_off` does."},
      {.table = "sweep", .key = "stop_after", .forms = kInteger,
       .meaning = "Ends the sweep at this many failures, in the order of point numbers; later points are left out. Not with "
                  "`find`.",
       .range = between(1, 1e9), .example = "100"},
      {.table = "sweep", .key = "keep_worst", .forms = kInteger, .default_toml = "5",
       .meaning = "Points named at the end: the farthest over their limits, or the nearest below.",
       .range = between(0, 1000)},
      {.table = "sweep", .key = "grid", .forms = kTable,
       .meaning = "Every combination of these values runs with every seed; the first key varies slowest."},
      {.table = "sweep", .key = "find", .forms = kTable,
       .meaning = "The sweep passes if there is such a value, whatever fails on its other side."},
      {.table = "sweep.grid", .key = "*", .forms = kTable | kAnything, .shape = Shape::one_or_list,
       .meaning = "A key of this scenario, as `--set` names it, and its values; a table stands for evenly spaced values.",
       .example = "[\"5 ms\", \"10 ms\"]"},
      {.table = "sweep.grid.*", .key = "from", .forms = kLimit,
       .meaning = "The first value.",
       .required = true, .example = "\"5 ms\""},
      {.table = "sweep.grid.*", .key = "to", .forms = kLimit,
       .meaning = "The last value, in the unit of the first.",
       .required = true, .example = "\"20 ms\""},
      {.table = "sweep.grid.*", .key = "count", .forms = kInteger,
       .meaning = "How many. Those between are rounded to twelve digits, times to a nanosecond.",
       .required = true, .range = between(2, 100'000), .example = "7"},
      {.table = "sweep.find", .key = "smallest", .forms = kText,
       .meaning = "This key of the grid: its smallest value for which it and all larger ones pass.",
       .example = "\"remap.latency\""},
      {.table = "sweep.find", .key = "largest", .forms = kText,
       .meaning = "This key of the grid: its largest value for which it and all smaller ones pass.",
       .example = "\"timing.visualization\""},
      {.table = "sweep.find", .key = "where", .forms = kWord, .default_toml = "\"all-pass\"",
       .meaning = "Every seed, with every value of the other keys.",
       .words = "all-pass"},
      {.table = "sweep.find", .key = "at_most", .forms = kLimit,
       .meaning = "With `smallest`: the sweep fails if the value found is larger.",
       .example = "\"16 ms\""},
      {.table = "sweep.find", .key = "at_least", .forms = kLimit,
       .meaning = "With `largest`: the sweep fails if the value found is smaller.",
       .example = "\"10 ms\""},
  };
  return rows;
}
// clang-format on

}  // namespace evenstep::internal
