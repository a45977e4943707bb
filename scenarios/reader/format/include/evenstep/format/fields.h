#pragma once
/// The field table: every key that a scenario may contain. The check of a file, its defaults, the JSON schema and the tables
/// in docs/reference/scenario-format.md are all made from it, so a key that is not in this table does not exist.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/text/quantity.h"

namespace evenstep::internal {

/// What a value may look like; several forms can be combined with |.
enum Form : std::uint32_t {
  kBoolean = 1 << 0,
  kInteger = 1 << 1,
  kNumber = 1 << 2,  ///< a number without a unit
  kText = 1 << 3,
  kFile = 1 << 4,  ///< a path relative to the file that names it
  kWord = 1 << 5,  ///< one of Field::words
  kDuration = 1 << 6,
  kSpan = 1 << 7,  ///< a duration, or in the nominal units of [timing]: "8 segments"
  kRate = 1 << 8,
  kQuantity = 1 << 9,   ///< a number with a unit of Field::dimension
  kJitter = 1 << 10,    ///< "lognormal 10 %" or "uniform 10 %"
  kSmooth = 1 << 11,    ///< "smooth 0.2 s"
  kLimit = 1 << 12,     ///< "4 step", "12 ms", 0
  kTable = 1 << 13,     ///< the fields of "<table>.<key>"
  kPareto = 1 << 14,    ///< "pareto 3 ms cap 40 ms"
  kSegments = 1 << 15,  ///< "8 segments", where their length does not matter
  kAnything = 1 << 16,  ///< a value for another key (of a grid); checked as a value of that key
  kWork = 1 << 18,      ///< "render 11.1 ms" or "burn 11.1 ms"
  kOptions = 1 << 17,   ///< a table that is passed on unread; no dates, for it becomes JSON
};

enum class Shape { one, list, one_or_list, three };

/// The allowed range in base units (s, Hz, m, N …). above_least: `least` itself is not allowed.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;
};

struct Field {
  std::string_view table;  ///< "" for the top of the file, "timing", "device.motion"
  std::string_view key;    ///< "*" allows any key; such a row is the only one of its table
  std::uint32_t forms = 0;
  Shape shape = Shape::one;
  std::string_view default_toml = "";  ///< the default as written in a file; empty: none
  std::string_view meaning;
  std::string_view words = "";  ///< "fill|real"
  std::string_view kinds = "";  ///< the key exists only if `kind` of its table (kind_key) is one of these: "sine|still";
                                ///< a [timing] with the key "trace" or "foreign" has that kind
  bool required = false;
  Dimension dimension = Dimension::none;
  Range range = {};
  std::string_view example = "";  ///< an example in TOML; empty: the default, or the example of its dimension
};

const std::vector<Field>& fields();
/// The key that gives the kind of a table: "order" for [timing], "coupling" for a grab, otherwise "kind".
std::string_view kind_key(std::string_view table);
std::vector<std::string_view> split_words(std::string_view words);  // at '|'
/// The names of all tables in the order of the field table: "", "run", "timing" …
std::vector<std::string_view> tables();
/// The name of the table that a kTable field contains: "timing.jitter"; [[expect_append]] contains the same as [[expect]].
std::string subtable(const Field& field);
/// The table as people write it: "[timing]", "[[device]]", "device.motion", "the top of the file".
std::string title(std::string_view table);
/// What a field accepts, for messages and docs: "\"fill\", \"real\" or a duration".
std::string describe_forms(const Field& field);
/// The range of a field in words: "above 0 s, at most 1e6 s"; empty if it has no bound.
std::string describe_range(const Field& field);
/// An example value of a field, as TOML.
std::string example_of(const Field& field);

}  // namespace evenstep::internal
