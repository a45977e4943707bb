#include "evenstep/format/fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/text/units.h"

namespace evenstep::internal {
namespace {

std::string_view base_unit_of(const Field& field) {
  if (field.forms & (kDuration | kSpan | kSmooth | kPareto | kWork)) return "s";
  if (field.forms & kSegments) return "segments";
  if (field.forms & kRate) return "Hz";
  if (field.dimension == Dimension::ratio) return "";
  if (field.forms & kQuantity) return info(field.dimension).base;
  return "";
}

std::string with_unit(double number, const Field& field) {
  const std::string_view unit = base_unit_of(field);
  return unit.empty() ? fmt::format("{}", number) : fmt::format("{} {}", number, unit);
}

std::string_view article(std::string_view noun) {
  return std::string_view("aeiou").find(noun.front()) == std::string_view::npos ? "a" : "an";
}

}  // namespace

std::string_view kind_key(std::string_view table) {
  return table == "timing" ? "order" : table == "device" ? "driver" : table == "device.grab" ? "coupling" : "kind";
}

std::vector<std::string_view> split_words(std::string_view words) {
  std::vector<std::string_view> out;
  while (!words.empty()) {
    const std::size_t bar = std::min(words.find('|'), words.size());
    out.push_back(words.substr(0, bar));
    words.remove_prefix(std::min(bar + 1, words.size()));
  }
  return out;
}

std::vector<std::string_view> tables() {
  std::vector<std::string_view> out;
  for (const Field& field : fields()) {
    if (std::find(out.begin(), out.end(), field.table) == out.end()) out.push_back(field.table);
  }
  return out;
}

std::string subtable(const Field& field) {
  if (field.key == "expect_append") return "expect";
  return field.table.empty() ? std::string(field.key) : fmt::format("{}.{}", field.table, field.key);
}

std::string title(std::string_view table) {
  if (table.empty()) return "the top of the file";
  if (table.find('.') != std::string_view::npos) return std::string(table);
  const auto named =
      std::find_if(fields().begin(), fields().end(), [&](const Field& f) { return f.table.empty() && f.key == table; });
  return named != fields().end() && named->shape == Shape::list ? fmt::format("[[{}]]", table) : fmt::format("[{}]", table);
}

std::string describe_forms(const Field& field) {
  std::vector<std::string> choices;
  if (field.forms & kWord) {
    for (const std::string_view word : split_words(field.words)) choices.push_back(fmt::format("\"{}\"", word));
  }
  if (field.forms & kBoolean) choices.emplace_back("true or false");
  if (field.forms & kInteger) choices.emplace_back("a whole number");
  if (field.forms & kNumber) choices.emplace_back("a number");
  if (field.forms & kText) choices.emplace_back("a string");
  if (field.forms & kFile) choices.emplace_back("a file");
  if (field.forms & (kDuration | kSpan)) choices.emplace_back("a time");
  if (field.forms & kRate) choices.emplace_back("a rate");
  if (field.forms & kQuantity)
    choices.push_back(fmt::format("{} {}", article(info(field.dimension).name), info(field.dimension).name));
  if (field.forms & kJitter) choices.insert(choices.end(), {"\"lognormal <ratio>\"", "\"uniform <ratio>\""});
  if (field.forms & kSmooth) choices.emplace_back("\"smooth <time>\"");
  if (field.forms & kWork) choices.insert(choices.end(), {"\"render <time>\"", "\"burn <time>\""});
  if (field.forms & kPareto) choices.emplace_back("\"pareto <time> cap <time>\"");
  if (field.forms & kSegments) choices.emplace_back("a number of segments");
  if (field.forms & kLimit) choices.emplace_back("a limit");
  if (field.forms & kAnything) choices.emplace_back("a value of that key");
  if (field.forms & (kTable | kOptions)) choices.emplace_back("a table");
  std::string out;
  for (std::size_t i = 0; i < choices.size(); ++i)
    out += (i == 0 ? "" : i + 1 == choices.size() ? " or " : ", ") + choices[i];
  switch (field.shape) {
    case Shape::one:
      return out;
    case Shape::list:
      return "a list, each " + out;
    case Shape::one_or_list:
      return out + ", or a list of them";
    case Shape::three:
      return "a list of three (x, y, z), each " + out;
  }
  return out;
}

std::string describe_range(const Field& field) {
  const Range& range = field.range;
  std::string out;
  if (std::isfinite(range.least)) out = (range.above_least ? "above " : "at least ") + with_unit(range.least, field);
  if (std::isfinite(range.most)) out += (out.empty() ? "at most " : " and at most ") + with_unit(range.most, field);
  return out;
}

std::string example_of(const Field& field) {
  if (!field.example.empty()) return std::string(field.example);
  if (!field.default_toml.empty()) return std::string(field.default_toml);
  if (field.forms & (kTable | kOptions)) return field.shape == Shape::list ? "[{}]" : "{}";
  return fmt::format("\"{}\"", info(field.dimension).example);
}

}  // namespace evenstep::internal
