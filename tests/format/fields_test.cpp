// The field table agrees with what people read: every key is accepted, has a meaning, and is in the schema and in the docs.
#include "evenstep/format/fields.h"

#include <fmt/format.h>

#include <fstream>
#include <iostream>
#include <set>
#include <sstream>

#include "catch.h"
#include "check.h"
#include "evenstep/format/scenario.h"
#include "evenstep/reports/json.h"
#include "evenstep/text/units.h"
#include "support.h"

using namespace evenstep;
using namespace evenstep::internal;
using Catch::Contains;

namespace {

std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

/// The tables of docs/reference/scenario-format.md, between its two markers.
std::string key_tables() {
  std::string out;
  for (const std::string_view table : tables()) {
    const std::string name = table.empty() ? "At the top of the file" : fmt::format("`{}`", title(table));
    out += fmt::format("\n### {}\n\n| key | value | default | meaning |\n|---|---|---|---|\n", name);
    for (const Field& field : fields()) {
      if (field.table != table) continue;
      const std::string range = describe_range(field);
      const std::string fallback = field.required               ? "obligatory"
                                   : field.default_toml.empty() ? "-"
                                                                : fmt::format("`{}`", field.default_toml);
      const std::vector<std::string_view> own = split_words(field.kinds),
                                          timings{"visualization-first", "steps-first", "concurrent", "accumulator"};
      std::string kinds;
      for (const std::string_view kind : own) kinds += fmt::format("{}`{}`", kinds.empty() ? "" : ", ", kind);
      if (field.table == "timing" && own.size() + 1 == timings.size()) {
        const auto missing = [&](std::string_view one) { return std::find(own.begin(), own.end(), one) == own.end(); };
        kinds = fmt::format("not `{}`", *std::find_if(timings.begin(), timings.end(), missing));
      }
      // Every kind but a trace. What a case leaves out is said at its key.
      const bool every = (field.table == "timing" && own.size() == timings.size()) || field.table.empty();
      out += fmt::format("| `{}` | {}{} | {} | {}{} |\n", field.key, cell(describe_forms(field)),
                         range.empty() ? "" : ", " + range, cell(fallback), kinds.empty() || every ? "" : kinds + ": ",
                         cell(std::string(field.meaning)));
    }
  }
  return out;
}

std::string unit_table() {
  std::string out = "\n| of | units |\n|---|---|\n";
  for (const Dimension d :
       {Dimension::time, Dimension::length, Dimension::velocity, Dimension::acceleration, Dimension::force, Dimension::slew,
        Dimension::angle, Dimension::torque, Dimension::stiffness, Dimension::damping, Dimension::energy, Dimension::mass,
        Dimension::rate, Dimension::ratio, Dimension::drift}) {
    std::string names;
    for (const Unit& unit : units()) {
      if (unit.dimension == d) names += fmt::format("{}`{}`", names.empty() ? "" : ", ", unit.name);
    }
    out += fmt::format("| {} | {} |\n", info(d).name, names);
  }
  return out;
}

std::string document() {
  std::ifstream file(EVENSTEP_SOURCE_DIR "/docs/reference/scenario-format.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

const Place kHere{"x.toml", 1, 1};

Value around(std::string_view key, Value value) {
  Value table = parse_toml_value("{}", kHere);
  table.table.push_back({std::string(key), kHere, std::move(value)});
  return table;
}

/// The entry that gives a table this kind.
Entry of_kind(std::string_view table, std::string_view kind) {
  if (table == "timing" && kind == "accumulator") return {"loop", kHere, text_value(std::string(kind), kHere)};
  const bool whole = table == "timing" && kind == "trace";  // its kind is a key of that name
  return {std::string(whole ? kind : kind_key(table)), kHere, text_value(std::string(whole ? "x.csv" : kind), kHere)};
}

/// Checks a document with this one key (and the kind that it needs). It may lack other things, but nothing may be wrong with
/// the key.
void check_alone(const Field& field, std::string_view toml) {
  INFO(field.table << "." << field.key << " = " << toml);
  Value document = around(field.key, parse_toml_value(toml, kHere));
  const std::vector<std::string_view> kinds = split_words(field.kinds);
  const std::string kind(kind_key(field.table));
  if (!kinds.empty() && field.key != kind && !field.table.empty()) {
    document.table.push_back(of_kind(field.table, kinds.front()));
  }
  for (std::string_view path = field.table; !path.empty();) {
    const std::size_t dot = path.rfind('.');
    const std::string_view key = dot == std::string_view::npos ? path : path.substr(dot + 1);
    if (key == "device" || key == "expect" || key == "changes" || key == "regions" || key == "moves" || key == "faults" ||
        key == "events" || key == "sometimes") {
      Value list = parse_toml_value("[]", kHere);
      list.list.push_back(std::move(document));
      document = std::move(list);
    }
    document = around(key, std::move(document));
    path = dot == std::string_view::npos ? std::string_view() : path.substr(0, dot);
    const auto needs_kind = [&](const Field& outer) {
      return !path.empty() && outer.table == path && outer.key == key && !outer.kinds.empty();
    };
    if (const auto outer = std::find_if(fields().begin(), fields().end(), needs_kind); outer != fields().end())
      document.table.push_back(of_kind(path, split_words(outer->kinds).front()));
  }
  Errors errors;
  const Check check(document, errors);
  for (const Diagnostic& error : errors.sorted("")) CHECK_THAT(error.message, Contains(" has no '"));
}

}  // namespace

TEST_CASE("Every key has a meaning that is a sentence, and its example and default pass its own check") {
  for (const Field& field : fields()) {
    INFO(field.table << " " << field.key);
    REQUIRE_FALSE(field.meaning.empty());
    CHECK((field.meaning.back() == '.' || field.meaning.back() == ')'));
    if (field.forms & kTable) continue;
    check_alone(field, example_of(field));
    if (!field.default_toml.empty()) check_alone(field, field.default_toml);
  }
}

TEST_CASE("A scenario with every key of its kind spelled out at its default is the scenario without them") {
  std::string text = test::kSpring;
  const auto spelled = [](std::string_view table, std::string_view kind, std::string_view but) {
    std::string lines;
    for (const Field& field : fields()) {
      const std::vector<std::string_view> kinds = split_words(field.kinds);
      const bool exists = kinds.empty() || std::find(kinds.begin(), kinds.end(), kind) != kinds.end();
      if (field.table == table && exists && !field.default_toml.empty() && field.key != but)
        lines += fmt::format("{} = {}\n", field.key, field.default_toml);
    }
    return lines;
  };
  const ReadResult plain = test::read_text(text);
  text.replace(text.find("warmup"), 0,
               "seed = 1\nstrategies = [\"ideal\", \"direct\", \"paper\", \"phase_locked\"]\nlive = \"phase_locked\"\n");
  text.replace(text.find("steps = "), 0, spelled("timing", "visualization-first", ""));
  text.replace(text.find("stiffness"), 0, spelled("scene", "spring", "stiffness"));
  text.replace(text.find("motion"), 0, spelled("device", "", ""));
  text += "[remap]\n" + spelled("remap", "", "") + "[remap.adapt]\n" + spelled("remap.adapt", "", "") +
          "[remap.estimate]\n" + spelled("remap.estimate", "", "") + "[remap.underrun]\n" +
          spelled("remap.underrun", "", "") + "[remap.filter]\n" + spelled("remap.filter", "butterworth", "");
  const ReadResult full = test::read_text(text);
  INFO(text << test::errors_of(full));
  REQUIRE(full);
  CHECK(test::describe(*full) == test::describe(*plain));
}

TEST_CASE("The document holds exactly the keys and units of the tables") {
  const std::string text = document();
  for (const auto& [marker, expected] :
       {std::pair<std::string, std::string>{"keys", key_tables()}, {"units", unit_table()}}) {
    const std::string begin = fmt::format("<!-- {}: begin (test_format \"[.print-{}]\" prints this) -->\n", marker, marker);
    const std::string end = fmt::format("<!-- {}: end -->", marker);
    const std::size_t from = text.find(begin), to = text.find(end);
    REQUIRE(from != std::string::npos);
    REQUIRE(to != std::string::npos);
    CHECK(text.substr(from + begin.size(), to - from - begin.size()) == expected);
  }
}

TEST_CASE("The fuzzer's dictionary has every key and word and unit of the tables") {
  std::ifstream in(EVENSTEP_SOURCE_DIR "/tests/fuzz/scenario.dict");
  std::set<std::string> tokens;
  for (std::string line; std::getline(in, line);) tokens.insert(line);
  for (const Field& field : fields()) {
    INFO(field.key << " " << field.words);
    if (field.key != "*") CHECK(tokens.count(fmt::format("\"{} = \"", field.key)) == 1);
    for (const std::string_view word : split_words(field.words)) CHECK(tokens.count(fmt::format(R"("\"{}\"")", word)) == 1);
  }
  for (const Unit& unit : units()) CHECK(tokens.count(fmt::format("\" {}\"", unit.name)) == 1);
}

TEST_CASE("print the key tables of docs/reference/scenario-format.md", "[.print-keys]") { std::cout << key_tables(); }
TEST_CASE("print the unit table of docs/reference/scenario-format.md", "[.print-units]") { std::cout << unit_table(); }

TEST_CASE("The schema is JSON of draft 4 that names every key and word once more") {
  const std::string schema = scenario_schema();
  CHECK_THAT(schema, Contains("http://json-schema.org/draft-04/schema#"));
  for (const Field& field : fields()) {
    const bool any_name = field.key == "*";
    CHECK_THAT(schema, Contains(any_name ? "\"additionalProperties\": {" : fmt::format("\"{}\": {{\n", field.key)));
    for (const std::string_view word : split_words(field.words)) CHECK_THAT(schema, Contains(fmt::format("\"{}\"", word)));
  }
  CHECK(Json::accept(schema));
}
