#pragma once
/// The pieces from which the rows of the field table (fields.h) are made. The rows of each section are in the file that
/// reads it.

#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/format/fields.h"
#include "evenstep/format/scenario.h"

namespace evenstep::internal {

constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr Range at_least(double least) { return {least, kAny, false}; }
constexpr Range above(double least, double most = kAny) { return {least, most, true}; }
constexpr Range between(double least, double most) { return {least, most, false}; }

// Limits, with their reasons:
constexpr double kLongestRun_s = 1e6;  // so that int64 ns, and sums of a few of them, are far from overflowing
constexpr double kLeastNumber = 1e-30, kMostNumber = 1e30;  // sizes of a number that is no whole one, unless it is 0
// Steps of a run: six hours at 450 Hz, and as many as a recording may have. The sizing passes keep up to 300 bytes for each.
constexpr std::int64_t kMostRunSteps = 10'000'000;
constexpr double kMostSteps = 1e6;      // per segment: 30 million steps per second, far beyond any device
constexpr double kMostParticles = 1e8;  // with 18 springs each: 1.8e9, the most that int32 indices can count
constexpr double kMostIterations = kMaxIterations, kMostSubsteps = kMaxSubsteps;  // the limits of the solvers
constexpr double kLongestSpike_s = 9;                                             // the longest segment

using D = Dimension;

// Values of [timing] order, which say what kind of table it is, unless `loop` does:
constexpr std::string_view kAnyOrder = "visualization-first|steps-first|concurrent";
constexpr std::string_view kInTurn = "visualization-first|steps-first";
constexpr std::string_view kAccumulator = "accumulator";
constexpr std::string_view kAnyLoop = "visualization-first|steps-first|concurrent|accumulator";
constexpr std::string_view kNoLanes = "visualization-first|steps-first|accumulator";

/// "a|b|c", the form of Field::words and Field::kinds, of the names that `name` gives for each element.
template <class List, class Name>
std::string words_of(const List& list, Name name) {
  std::string words;
  for (const auto& one : list) {
    if (!words.empty()) words += '|';
    words += name(one);
  }
  return words;
}
/// The names of all strategies; the text lives as long as the program.
std::string_view strategy_words();
std::string_view method_words();

/// `rows`, and `more` after them.
inline std::vector<Field> joined(std::vector<Field> rows, const std::vector<Field>& more) {
  rows.insert(rows.end(), more.begin(), more.end());
  return rows;
}
/// The rows of a table for a part that the program registers. `kinds` are the kinds of the table that have them; empty: all.
std::vector<Field> foreign_rows(std::string_view table, std::string_view kinds);
/// `library` and `options`: the short form of a table `foreign` with them.
std::vector<Field> library_rows(std::string_view table, std::string_view kinds);

/// [[device]] NAME = { ... }, the obligatory table of a driver of that name.
inline Field driver_table_row(std::string_view name, std::string_view meaning) {
  return {.table = "device", .key = name, .forms = kTable, .meaning = meaning, .kinds = name, .required = true};
}
/// The row for how often a driver's device is told something, with its default.
inline Field update_rate_row(std::string_view table, std::string_view default_toml, std::string_view meaning,
                             double most_Hz) {
  return {.table = table,
          .key = "update_rate",
          .forms = kRate,
          .default_toml = default_toml,
          .meaning = meaning,
          .range = between(1, most_Hz)};
}

const std::vector<Field>& case_fields();
const std::vector<Field>& run_fields();
const std::vector<Field>& timing_fields();
const std::vector<Field>& timing_model_fields();  // the last rows of [timing]: what makes times irregular
const std::vector<Field>& scene_fields();
const std::vector<Field>& device_fields();
const std::vector<Field>& motion_fields();
const std::vector<Field>& driver_fields();
const std::vector<Field>& remap_fields();
const std::vector<Field>& source_fields();
const std::vector<Field>& study_fields();
const std::vector<Field>& sweep_fields();
const std::vector<Field>& recovery_fields();
const std::vector<Field>& expect_fields();

}  // namespace evenstep::internal
