#include "check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <cmath>

#include "evenstep/text/suggest.h"
#include "evenstep/text/units.h"
#include "field_rows.h"

namespace evenstep::internal {
namespace {

constexpr std::string_view kLognormalWord = "lognormal ", kUniformWord = "uniform ";
constexpr std::string_view kSmoothWord = "smooth ";
constexpr std::string_view kRenderWord = "render ", kBurnWord = "burn ";
constexpr std::string_view kSweepRange = "sweep.grid.*";
constexpr std::string_view kParetoWord = "pareto ", kCapWord = " cap ";
/// Any lengths do for the check of the forms; those of the scenario are read from [timing] later.
constexpr Duration kSome{1'000'000};
constexpr NominalUnits kSomeNominal{
    .segment = kSome, .visualization = kSome, .slot = kSome, .step_run_time = kSome, .known = true};

/// A division gives exactly the limit 1e6 s for 1e15 ns; a product with 1e-9 would not.
double in_s(Duration duration) { return static_cast<double>(duration.ns) / 1e9; }

bool contains(std::string_view words, std::string_view word) {
  const std::vector<std::string_view> all = split_words(words);
  return std::find(all.begin(), all.end(), word) != all.end();
}

/// The kind of this table, to be compared with `Field::kinds`; empty if it is not known, and then no key is refused because
/// of it.
std::string kind_of(std::string_view table, const Value* value) {
  if (table.empty()) return value != nullptr && value->find("case") != nullptr ? "case" : "loop";
  const std::string_view key = kind_key(table);
  const auto row =
      std::find_if(fields().begin(), fields().end(), [&](const Field& f) { return f.table == table && f.key == key; });
  for (const char* whole : {"trace", "foreign"}) {
    if (table == "timing" && value != nullptr && value->find(whole) != nullptr) return whole;
  }
  const Value* const loop = table == "timing" && value != nullptr ? value->find("loop") : nullptr;
  if (loop != nullptr && loop->text == kAccumulator) return loop->text;
  for (const char* part : {"library", "command"}) {
    if (table == "scene" && value != nullptr && value->find(part) != nullptr && value->find(key) == nullptr)
      return "foreign";
  }
  const Value* kind = value == nullptr ? nullptr : value->find(key);
  if (kind == nullptr && row != fields().end() && !row->required)
    return std::string(row->default_toml.substr(1, row->default_toml.size() - 2));  // without its quotes
  if (kind == nullptr || !kind->is(Value::Kind::text)) return "";
  return row != fields().end() && contains(row->words, kind->text) ? kind->text : "";
}

bool exists_for(const Field& field, std::string_view kind) {
  return field.kinds.empty() || kind.empty() || contains(field.kinds, kind);
}

/// The row of a key for this kind; any row of the key if there is none for this kind; nullptr if the key is unknown.
const Field* row_of(std::string_view table, std::string_view key, std::string_view kind) {
  const Field* any = nullptr;
  for (const Field& field : fields()) {
    if (field.table != table || (field.key != key && field.key != "*")) continue;
    if (exists_for(field, kind)) return &field;
    any = &field;
  }
  return any;
}

std::string out_of_range(const Field& field, double number, std::string_view written) {
  const Range& range = field.range;
  const bool below = range.above_least ? !(number > range.least) : !(number >= range.least);
  if (!below && number <= range.most) {
    // Products and quotients of a few such numbers are far from the ends of what a double holds.
    const bool is_real = (field.forms & (kQuantity | kNumber)) != 0 && number != 0;
    if (!is_real || (std::abs(number) >= kLeastNumber && std::abs(number) <= kMostNumber)) return {};
    return fmt::format("{} is out of range; a number is 0, or between {} and {} in size, in base units", written,
                       kLeastNumber, kMostNumber);
  }
  return fmt::format("{} is out of range; it must be {}", written, describe_range(field));
}

/// The error for a number without its unit, such as 11.1 instead of "11.1 ms".
std::string without_unit(const Field& field, const Value& value) {
  if (field.forms & kSegments)
    return fmt::format("{} has no unit; write \"{} segments\"", as_written(value), as_written(value));
  const Dimension dimension = (field.forms & kRate)                                     ? Dimension::rate
                              : (field.forms & (kDuration | kSpan | kSmooth | kPareto)) ? Dimension::time
                              : (field.forms & kJitter)                                 ? Dimension::ratio
                                                                                        : field.dimension;
  const std::string_view example = info(dimension).example;
  return fmt::format("{} has no unit; write {} such as \"{}{}\"", as_written(value), describe_forms(field),
                     as_written(value), example.substr(example.find(' ')));
}

double number_of(double value) { return value; }
double number_of(Duration value) { return in_s(value); }
double number_of(Rate value) { return static_cast<double>(value.num) / static_cast<double>(value.den); }

template <class T>
std::string parsed(const Field& field, const Result<T>& result, std::string_view text) {
  return result ? out_of_range(field, number_of(*result), fmt::format("\"{}\"", text)) : result.error();
}

std::string prefixed_error(const Field& field, std::string_view text, std::string_view word, bool time) {
  if (text.substr(0, word.size()) != word)
    return fmt::format("\"{}\" must be {}, such as {}", text, describe_forms(field), example_of(field));
  const std::string_view rest = text.substr(word.size());
  return time ? parsed(field, parse_duration(rest), text) : parsed(field, parse_si(rest, Dimension::ratio), text);
}

/// The two times of "pareto 3 ms cap 40 ms"; none if the text has another form.
struct ParetoParts {
  std::string_view least, most;
};
ParetoParts pareto_parts(std::string_view text) {
  const std::size_t cap = text.find(kCapWord);
  if (text.substr(0, kParetoWord.size()) != kParetoWord || cap == std::string_view::npos) return {};
  return {text.substr(kParetoWord.size(), cap - kParetoWord.size()), text.substr(cap + kCapWord.size())};
}

std::string pareto_error(const Field& field, std::string_view text) {
  const ParetoParts parts = pareto_parts(text);
  if (parts.least.empty() || parts.most.empty())
    return fmt::format("\"{}\" must be {}, such as {}", text, describe_forms(field), example_of(field));
  const Result<Duration> least = parse_duration(parts.least), most = parse_duration(parts.most);
  if (!least) return least.error();
  if (!most) return most.error();
  const std::string range = out_of_range(field, in_s(*least), fmt::format("\"{}\"", text));
  if (!range.empty() || *least <= *most) return range.empty() ? out_of_range(field, in_s(*most), text) : range;
  return fmt::format("\"{}\": the cap is below the least cost; write the smaller time first", text);
}

/// The word that a visualization's time follows; empty if there is none.
std::string_view work_word(std::string_view text) {
  for (const std::string_view word : {kRenderWord, kBurnWord})
    if (text.substr(0, word.size()) == word) return word;
  return {};
}

bool is_uniform(std::string_view text) { return text.substr(0, kUniformWord.size()) == kUniformWord; }

/// The number of "8 segments".
Result<double> parse_segments(std::string_view text) {
  const NumberAndUnit split = split_number(text);
  const Unit* unit = split.error.empty() ? find_unit(split.unit) : nullptr;
  if (unit == nullptr || unit->kind != UnitKind::segment || split.divisor.mantissa != 1)
    return Failure(fmt::format("'{}' must be a number of segments, such as \"8 segments\"", text));
  return to_double(split.number);
}

/// The error of a value that may be a rate or a duration, depending on the unit that it has.
std::string time_or_rate_error(const Field& field, std::string_view text) {
  const Unit* unit = find_unit(split_number(text).unit);
  const bool rate =
      (field.forms & kRate) && (!(field.forms & kDuration) || (unit != nullptr && unit->dimension == Dimension::rate));
  if (rate) return parsed(field, parse_rate(text), text);
  return parsed(field, parse_duration(text, field.forms & kSpan ? kSomeNominal : NominalUnits{}), text);
}

bool starts_like_number(std::string_view text) {
  return !text.empty() && std::string_view("0123456789.+-").find(text.front()) != std::string_view::npos;
}

std::string text_error(const Field& field, const std::string& text) {
  if (field.forms & kText) return {};
  if (field.forms & kFile) return text.empty() ? "names no file" : "";
  if ((field.forms & kWork) && !work_word(text).empty()) return prefixed_error(field, text, work_word(text), true);
  constexpr std::uint32_t kNumeric = kDuration | kSpan | kRate | kQuantity | kLimit;
  if (field.forms & kWord) {
    if (contains(field.words, text)) return {};
    if (!(field.forms & kNumeric) || !starts_like_number(text)) {
      const std::string near(nearest(text, split_words(field.words)));
      return fmt::format("\"{}\" must be {}{}", text, describe_forms(field),
                         near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
    }
  }
  if (field.forms & kJitter) return prefixed_error(field, text, is_uniform(text) ? kUniformWord : kLognormalWord, false);
  if (field.forms & kSmooth) return prefixed_error(field, text, kSmoothWord, true);
  if (field.forms & kPareto) return pareto_error(field, text);
  if (field.forms & kSegments) return parsed(field, parse_segments(text), text);
  if (field.forms & (kDuration | kSpan | kRate)) return time_or_rate_error(field, text);
  if (field.forms & kLimit) return parse_limit(text).error_or("");
  if (field.forms & kQuantity) return parsed(field, parse_si(text, field.dimension), text);
  const std::string must = fmt::format("\"{}\" must be {}, without quotes", text, describe_forms(field));
  const NumberAndUnit split = split_number(text);
  if (!(field.forms & (kInteger | kNumber)) || !split.error.empty() || split.divisor.mantissa != 1) return must;
  return must + fmt::format("{}: {}", split.unit.empty() ? "" : " or unit", to_double(split.number));
}

/// What is wrong with a value; empty if nothing is.
std::string error_of(const Field& field, const Value& value) {
  if ((field.forms & kAnything) && !value.is(Value::Kind::date)) return {};
  const std::string wrong = fmt::format("must be {}, not {}", describe_forms(field), as_written(value));
  switch (value.kind) {
    case Value::Kind::text:
      return text_error(field, value.text);
    case Value::Kind::boolean:
      return field.forms & kBoolean ? "" : wrong;
    case Value::Kind::number:
      if (!std::isfinite(value.number)) return fmt::format("{} is not a number a scenario can use", value.number);
      [[fallthrough]];
    case Value::Kind::integer: {
      const bool whole = value.is(Value::Kind::integer);
      const double number = whole ? static_cast<double>(value.integer) : value.number;
      if (field.forms & kLimit) return {};
      if ((field.forms & kNumber) || (whole && (field.forms & kInteger)))
        return out_of_range(field, number, as_written(value));
      if (field.forms & (kDuration | kSpan | kRate | kQuantity | kJitter | kSmooth | kPareto | kSegments))
        return without_unit(field, value);
      return wrong;
    }
    default:
      return wrong;
  }
}

/// A date somewhere in a value. JSON has no form for one.
const Value* date_in(const Value& value) {
  if (value.is(Value::Kind::date)) return &value;
  for (const Value& one : value.list) {
    if (const Value* found = date_in(one)) return found;
  }
  for (const Entry& entry : value.table) {
    if (const Value* found = date_in(entry.value)) return found;
  }
  return nullptr;
}

/// The key as shown in messages; for a key that may have any name, its table.
std::string shown_key(const Field& field) { return field.key == "*" ? title(field.table) : fmt::format("'{}'", field.key); }

/// What to write for a missing table. For a table within another one that is all that it must have, on one line; or its
/// first key, if it must have one of several.
std::string table_to_write(const Field& field) {
  std::string keys;
  const auto& all = fields();
  const auto needs = [&](const Field& one) { return one.table == subtable(field) && one.required && one.kinds.empty(); };
  const bool needs_any = std::any_of(all.begin(), all.end(), needs);
  for (const Field& one : all) {
    if (needs_any ? !needs(one) : one.table != subtable(field) || !keys.empty()) continue;
    keys += fmt::format("{}{} = {}", keys.empty() ? "" : ", ", one.key, example_of(one));
  }
  return field.table.empty() || keys.empty() ? title(field.key) : fmt::format("{} = {{ {} }}", field.key, keys);
}

/// "device.NAME.rate": where a key of this table stands, as --set writes it.
std::string path_of(const Field& field) {
  std::string path, table;
  for (std::string_view rest = field.table; !rest.empty();) {
    const std::string_view part = rest.substr(0, rest.find('.'));
    rest.remove_prefix(std::min(part.size() + 1, rest.size()));
    const Field* its = row_of(table, part, {});
    path += fmt::format("{}.{}", part, its == nullptr || its->shape != Shape::list ? "" : part == "device" ? "NAME." : "0.");
    table += fmt::format("{}{}", table.empty() ? "" : ".", part);
  }
  return fmt::format("{}{}", path, field.key);
}

/// What an unknown key may have been meant to be: the same key of another table, which is left out if many have it
/// ("kind"), or a key of this table that is written much like it.
std::string what_was_meant(std::string_view table, std::string_view key, std::string_view kind) {
  if (table == kSweepRange) return "; a path stands in quotes: \"timing.visualization\"";
  std::vector<std::string_view> known;
  std::vector<std::string> elsewhere;
  for (const Field& field : fields()) {
    if (field.table == table && exists_for(field, kind)) known.push_back(field.key);
    if (field.key == key && field.table != kSweepRange) elsewhere.push_back(path_of(field));
  }
  std::sort(elsewhere.begin(), elsewhere.end());
  elsewhere.erase(std::unique(elsewhere.begin(), elsewhere.end()), elsewhere.end());  // a key may have a row for each kind
  constexpr std::size_t kFew = 4;
  if (elsewhere.empty() || elsewhere.size() > kFew) return suggestion(key, known);
  return fmt::format("; such a key is {}", fmt::join(elsewhere, ", or "));
}

}  // namespace

Check::Check(const Value& document, Errors& errors) : errors_(errors) { table("", document); }

void Check::table(const std::string& name, const Value& value) {
  const std::size_t before = errors_.count();
  for (const Entry& one : value.table) entry(name, value, one);
  missing(name, value);
  if (errors_.count() > before) faulty_.insert(&value);
}

void Check::entry(const std::string& name, const Value& table, const Entry& entry) {
  const std::string kind = kind_of(name, &table);
  const Field* field = row_of(name, entry.key, kind);
  if (field == nullptr) {
    errors_.add(entry.place,
                fmt::format("unknown key '{}' in {}{}", entry.key, title(name), what_was_meant(name, entry.key, kind)));
  } else if (!exists_for(*field, kind)) {
    const std::string_view of = kind_key(name);
    errors_.add(
        entry.place,
        kind == "case"
            ? fmt::format("'{}' does not go with [case], which drives the solver itself; remove one of them", entry.key)
        : name == "timing" && (kind == "trace" || kind == "foreign")
            ? fmt::format("'{}' does not go with '{}': the {} says it all; remove one of them", entry.key, kind,
                          kind == "trace" ? "recording" : "source")
        : name == "timing" && kind == kAccumulator
            ? fmt::format("'{}' means nothing with loop = \"accumulator\"; remove it", entry.key)
        : field->kinds == kAccumulator
            ? fmt::format("'{}' is about a game's loop; remove it, or write loop = \"accumulator\"", entry.key)
        : field->kinds == "trace"
            ? fmt::format("'{}' belongs to a recording; remove it, or write trace = \"trace.sqlite\"", entry.key)
            : fmt::format("'{}' means nothing with {} = \"{}\"; remove it, or write {} = \"{}\"", entry.key, of, kind, of,
                          fmt::join(split_words(field->kinds), "\" or \"")));
  } else {
    value(*field, entry.value);
  }
}

void Check::value(const Field& field, const Value& value) {
  const std::size_t before = errors_.count();
  const bool list = value.is(Value::Kind::list);
  if (field.shape == Shape::one || (field.shape == Shape::one_or_list && !list)) {
    element(field, value);
  } else if (!list || (field.shape == Shape::three && value.list.size() != 3) ||
             (field.shape == Shape::one_or_list && value.list.empty())) {
    const std::string hint = (field.forms & kTable) && field.table.empty() ? fmt::format("; write [[{}]]", field.key)
                                                                           : fmt::format(", such as {}", example_of(field));
    errors_.add(value.place, fmt::format("{} must be {}{}", shown_key(field), describe_forms(field), hint));
  } else {
    for (const Value& one : value.list) element(field, one);
  }
  if (errors_.count() > before) faulty_.insert(&value);
}

void Check::element(const Field& field, const Value& value) {
  if ((field.forms & kTable) && value.is(Value::Kind::table)) return table(subtable(field), value);
  if ((field.forms & kOptions) && value.is(Value::Kind::table)) {
    if (const Value* date = date_in(value))
      errors_.add(date->place, fmt::format("{}: a date cannot be passed on as JSON; write it as text", shown_key(field)));
    return;
  }
  const std::string error = error_of(field, value);
  if (!error.empty()) errors_.add(value.place, fmt::format("{}: {}", shown_key(field), error));
}

void Check::missing(const std::string& name, const Value& value) {
  const std::string kind = kind_of(name, &value);
  for (const Field& field : fields()) {
    // Without a valid kind nothing can be said of the keys that depend on it.
    if (field.table != name || !field.required || value.find(field.key) != nullptr) continue;
    if (!field.kinds.empty() && (kind.empty() || !contains(field.kinds, kind))) continue;
    if (field.key == kind_key(name) && !kind.empty()) continue;  // another key says what it is
    const std::string remedy =
        field.forms != kTable ? fmt::format("{} = {}", field.key, example_of(field)) : table_to_write(field);
    errors_.add(value.place, fmt::format("{} has no '{}'; write {}", title(name), field.key, remedy));
  }
}

bool Table::exists(std::string_view key) const {
  const std::string kind = kind_of(name_, value_);
  const Field* field = row_of(name_, key, kind);
  return field != nullptr && exists_for(*field, kind);
}

const Field& Table::field(std::string_view key) const { return *row_of(name_, key, kind_of(name_, value_)); }

Place Table::place(std::string_view key) const {
  if (has(key)) return value_->find(key)->place;
  return value_ != nullptr ? value_->place : around_;
}

Value Table::at(std::string_view key) const {
  if (has(key)) return *value_->find(key);
  return parse_toml_value(field(key).default_toml, place(key));
}

Table Table::table(std::string_view key) const {
  return {has(key) ? value_->find(key) : nullptr, subtable(field(key)), place(key)};
}

double Table::number(std::string_view key) const {
  const Value value = at(key);
  return value.is(Value::Kind::integer) ? static_cast<double>(value.integer) : value.number;
}

double Table::si(std::string_view key) const { return *parse_si(text(key), field(key).dimension); }

glm::dvec3 Table::vector(std::string_view key) const {
  const Value value = at(key);
  glm::dvec3 out{0};
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = *parse_si(value.list[static_cast<std::size_t>(axis)].text, field(key).dimension);
  return out;
}

Duration Table::span(std::string_view key, const NominalUnits& nominal, Errors& errors) const {
  const Result<Duration> parsed = parse_duration(text(key), nominal);
  if (!parsed && nominal.known) errors.add(place(key), fmt::format("'{}': {}", key, parsed.error()));
  return parsed.value_or({});
}

std::int64_t Table::whole_ppm(std::string_view key, Errors& errors) const {
  const double ppm = *in_unit(si(key), "ppm", "1", 0, {});
  const auto whole = static_cast<std::int64_t>(ppm);
  if (static_cast<double>(whole) != ppm)
    errors.add(place(key), fmt::format("'{}': \"{}\" is finer than 1 ppm; write whole millionths, such as \"{} ppm\"", key,
                                       text(key), whole));
  return whole;
}

JitterText Table::jitter(std::string_view key) const {
  const std::string written = text(key);
  const bool uniform = is_uniform(written);
  const std::string ratio = written.substr((uniform ? kUniformWord : kLognormalWord).size());
  return {uniform ? JitterLaw::uniform : JitterLaw::log_normal, *parse_si(ratio, Dimension::ratio)};
}

WorkText Table::work(std::string_view key) const {
  const std::string written = text(key);
  const std::string_view word = work_word(written);
  const bool is_render = word == kRenderWord || written == "render";
  WorkText out{is_render      ? VisualizationWork::render
               : word.empty() ? VisualizationWork::pause
                              : VisualizationWork::burn,
               std::nullopt};
  if (written != "render") out.length = *parse_duration(std::string_view(written).substr(word.size()));
  return out;
}

ParetoText Table::pareto(std::string_view key) const {
  const std::string written = text(key);
  const ParetoParts parts = pareto_parts(written);
  return {*parse_duration(parts.least), *parse_duration(parts.most)};
}

double Table::segments(std::string_view key) const { return *parse_segments(text(key)); }

std::vector<Table> Table::tables(std::string_view key) const {
  std::vector<Table> out;
  if (!has(key)) return out;
  for (const Value& one : value_->find(key)->list) out.emplace_back(&one, subtable(field(key)), one.place);
  return out;
}

Duration Table::smooth(std::string_view key) const { return *parse_duration(text(key).substr(kSmoothWord.size())); }

}  // namespace evenstep::internal
