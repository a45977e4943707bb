// Every key of the format with extreme values: a value is refused with its place and a remedy, or every command that takes
// the scenario ends as documented, in bounded time and memory. The keys and the forms of their values come from the field
// table, so a new key is tried without being named.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iostream>
#include <set>

#include "../own_parts/parts.h"
#include "cases.h"
#include "catch.h"
#include "evenstep/text/units.h"
#include "law_bench.h"
#include "program.h"
#include "scenario_generator.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace evenstep::testing;
using namespace evenstep::internal;

namespace {

/// What a 64-bit number, a double or a time in ns can just hold, or no longer, and what is nothing.
constexpr std::string_view kNumbers[] = {"0",
                                         "-1",
                                         "1",
                                         "1e300",
                                         "-1e300",
                                         "5e-324",
                                         "1e-300",
                                         "2147483648",
                                         "4294967296",
                                         "9007199254740993",
                                         "9223372036854775807",
                                         "9223372036854775808",
                                         "-9223372036854775808",
                                         "18446744073709551615",
                                         "0.000000001",
                                         "99999.999999999",
                                         "1000000",
                                         "inf",
                                         "nan"};

std::vector<std::string> units_of(const Field& field) {
  std::vector<Dimension> dimensions;
  if (field.forms & (kDuration | kSpan | kSmooth | kPareto | kWork | kLimit)) dimensions.push_back(Dimension::time);
  if (field.forms & kRate) dimensions.push_back(Dimension::rate);
  if (field.forms & kQuantity) dimensions.push_back(field.dimension);
  if (field.forms & kJitter) dimensions.push_back(Dimension::ratio);
  std::vector<std::string> names;
  for (const Dimension dimension : dimensions) {
    names.emplace_back(info(dimension).base);
    for (const Unit& unit : units())
      if (unit.dimension == dimension) names.emplace_back(unit.name);
  }
  if (field.forms & (kSegments | kSpan)) names.emplace_back("segments");
  std::sort(names.begin(), names.end());
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

/// Extreme values of a key, as TOML.
std::vector<std::string> extremes_of(const Field& field) {
  std::vector<std::string> ones;
  std::vector<std::string> numbers(std::begin(kNumbers), std::end(kNumbers));
  for (const double edge : {field.range.least, field.range.most}) {
    if (!std::isfinite(edge)) continue;
    for (const double beside : {std::nextafter(edge, -INFINITY), edge, std::nextafter(edge, INFINITY)})
      numbers.push_back(fmt::format("{}", beside));
  }
  if (field.forms & (kInteger | kNumber | kLimit)) ones = numbers;
  for (const std::string& unit : units_of(field)) {
    for (const std::string& number : numbers) {
      const std::string value = number + (unit == "1" ? "" : ' ' + unit);
      if (field.forms & (kDuration | kSpan | kRate | kQuantity | kSegments | kLimit)) ones.push_back('"' + value + '"');
      if (field.forms & kSmooth) ones.push_back("\"smooth " + value + '"');
      if (field.forms & kWork) ones.insert(ones.end(), {"\"render " + value + '"', "\"burn " + value + '"'});
      if (field.forms & kJitter) ones.insert(ones.end(), {"\"lognormal " + value + '"', "\"uniform " + value + '"'});
      if (field.forms & kPareto)
        ones.insert(ones.end(), {"\"pareto " + value + " cap 9 s\"", "\"pareto 1 ns cap " + value + '"'});
    }
  }
  if (field.forms & kWord)
    for (const std::string_view word : split_words(field.words)) ones.push_back(fmt::format("\"{}\"", word));
  if (field.forms & (kText | kFile))
    ones.insert(ones.end(), {"\"/dev/null\"", "\"/dev/zero\"", "\"/\"", "\"a\\nb\"", "\"\\u0000\"", "\"*\"", "\"..\"",
                             '"' + std::string(100'000, 'x') + '"'});
  // What it cannot be.
  for (const std::string_view other : {"true", "\"\"", "{}", "[]", "1979-05-27", "'x y'", "[[]]", "[1]"})
    ones.emplace_back(other);
  if (field.shape == Shape::one) return ones;
  std::vector<std::string> out;
  for (const std::string& one : ones) {
    if (field.shape == Shape::three) {
      out.insert(out.end(), {fmt::format("[{}, {}, {}]", one, one, one), fmt::format("[{}, {}]", one, one)});
    } else {
      out.push_back(fmt::format("[{}]", one));
      if (field.shape == Shape::one_or_list) out.push_back(one);
    }
  }
  if (field.shape == Shape::list && !ones.empty()) {
    const std::string example = example_of(field), element = example.substr(1, example.size() - 2) + ',';
    std::string many = "[";
    while (many.size() < 500'000) many += element;  // a file may have twice as much
    // Each of these numbers is a run of its own, not a mistake.
    if (field.table == "study") many = many.substr(0, 60 / element.size() * element.size() + 1);
    out.push_back(many + ']');
  }
  return out;
}

/// Keys with a value that no other test has the parts or files for: `library` and what stands beside it, and `extends`.
bool is_tried(const Field& field) {
  return !(field.forms & kTable && !(field.forms & ~std::uint32_t{kTable})) && field.key != "library" &&
         field.key != "extends" && !(field.key == "options" && field.meaning.starts_with("With `library`"));
}
/// The command that has a use for the table of this key, beside `run` and `check`.
std::vector<std::string> commands_for(std::string_view table) {
  if (table.starts_with("sweep") || table == "sometimes") return {"sweep"};
  if (table.starts_with("study")) return {"study"};
  if (table.starts_with("timing") || table.starts_with("remap") || table.starts_with("device")) return {"run", "size"};
  return {"run"};
}

std::vector<std::string> arguments_of(const std::string& command, const std::string& scenario) {
  if (command == "run" || command == "sweep") return {command, scenario, "--out", "out"};
  return {command, scenario};
}

constexpr ProgramLimits kLimits{.interrupt_after_s = 1, .end_after_s = 20};

/// What is wrong with how a command ended; empty: nothing.
std::string complaint(const Ended& ended) {
  if (ended.signal) return fmt::format("ended by signal {}", ended.signal);
  static const std::set<int> documented{0, 1, 2, 3, 4, 130};
  if (!documented.contains(ended.exit_code)) return fmt::format("exit code {} is not documented", ended.exit_code);
  if (ended.output.find("bad_alloc") != std::string::npos || ended.output.find("length_error") != std::string::npos)
    return "asked for memory that is not there";
  if (ended.exit_code == 2 && ended.output.find("scenario.toml") == std::string::npos) return "refused without a place";
  return "";
}

/// The first of the places where this key stands in a scenario that the reader takes.
struct Stand {
  GeneratedScenario scenario;
  ScenarioTable* table = nullptr;
  std::string key;
};
Stand stand_of(const Field& field, const std::string& folder, const Registry& registry) {
  Stand stand;
  ScenarioGenerator generator(1, folder, registry);
  for (int attempt = 0; attempt < 200 && !stand.scenario.is_valid; ++attempt)
    stand.scenario = generator.scenario_with(field, 0.02 + 0.01 * (attempt % 40));
  const std::vector<ScenarioTable*> tables = tables_at(stand.scenario.root, field.table);
  if (stand.scenario.is_valid && !tables.empty()) stand.table = tables.front();
  stand.key = field.key == "*" ? "remap.latency" : field.key;
  return stand;
}

struct Tried {
  std::size_t values = 0, taken = 0, runs = 0;
};

/// For one in `key_share` of the keys, another choice each day, reads a scenario with one in `read_share` of the values, and
/// runs one in `share` of those that the reader takes, with these commands or, if there are none, with those that have a use
/// for the key. EVENSTEP_KEY=remap.latency tries one key only, with all of its values.
Tried try_extremes(std::uint64_t key_share, std::uint64_t read_share, std::uint64_t share,
                   const std::vector<std::string>& commands) {
  const TemporaryFolder folder;
  write_recordings(folder.path().string());
  const std::string path = folder / "scenario.toml";
  const Registry registry = own_parts::registry();
  const char* const only = std::getenv("EVENSTEP_KEY");
  Tried tried;
  std::mt19937_64 random(static_cast<std::uint64_t>(today().time_since_epoch().count()));
  for (const Field& field : fields()) {
    if (!is_tried(field) || (only && name_of(field) != only)) continue;
    if (!only && random() % key_share != 0) continue;
    INFO(name_of(field) << " (" << field.kinds << ")");
    Stand stand = stand_of(field, folder.path().string(), registry);
    INFO(stand.scenario.toml);
    if (!stand.table) FAIL_CHECK("no scenario with this key was found");
    for (const std::string& value : stand.table ? extremes_of(field) : std::vector<std::string>{}) {
      if (!only && random() % read_share != 0) continue;
      ++tried.values;
      stand.table->set(stand.key, value);
      std::ofstream(path) << to_text(stand.scenario.root).toml;
      const ReadResult read = read_scenario(path, {.registry = registry});
      for (const Diagnostic& error : read.error_or({})) {
        if (error.line < 1 || error.column < 1 || error.message.empty())
          FAIL_CHECK(value.substr(0, 100) << ": refused without a place: " << evenstep::text(error));
      }
      if (!read) continue;
      ++tried.taken;
      if (!only && random() % share != 0) continue;
      for (const std::string& command : commands.empty() ? commands_for(field.table) : commands) {
        ++tried.runs;
        const Ended ended = run_program(arguments_of(command, path), folder.path().string(), registry, kLimits);
        if (const std::string fault = complaint(ended); !fault.empty())
          FAIL_CHECK(command << " with " << value.substr(0, 100) << ": " << fault << '\n' << ended.text());
      }
    }
  }
  std::cout << tried.values << " values, " << tried.taken << " taken, " << tried.runs << " runs\n";
  return tried;
}

}  // namespace

TEST_CASE("Every key with extreme values is refused with its place, or the commands that use it end as documented") {
  const Tried tried =
      try_extremes(kSanitized ? 60 : 5, 3, 7, {});  // to find a scenario with a key takes a second with sanitizers
  if (std::getenv("EVENSTEP_KEY")) return;
  CHECK(tried.values > share_of(10 * 30));
  CHECK(tried.taken > share_of(10 * 7));
  if (!kSanitized) CHECK(tried.runs > share_of(10));  // of so few values chance may run none
}

TEST_CASE("Every extreme value that is taken ends every command as documented", "[million]") {
  try_extremes(1, 1, 1, {"run", "check", "size", "study", "sweep"});
}
