#pragma once
/// The field table: every key a scenario may hold. The check of a file, its defaults, the JSON schema and the tables in
/// docs/scenario-format.md all come from here, so a key that is not in it exists nowhere.

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/text/quantity.h"

namespace evenstep::internal {

/// What a value may look like; several may be joined.
enum Form : std::uint32_t {
  kBoolean = 1 << 0,
  kInteger = 1 << 1,
  kNumber = 1 << 2,  ///< plain, no unit
  kText = 1 << 3,
  kFile = 1 << 4,  ///< relative to the file that names it
  kWord = 1 << 5,  ///< one of Field::words
  kDuration = 1 << 6,
  kSpan = 1 << 7,  ///< a duration, or in the nominal units of [timing]: "8 segments"
  kRate = 1 << 8,
  kQuantity = 1 << 9,    ///< SI, of Field::dimension
  kLognormal = 1 << 10,  ///< "lognormal 10 %"
  kSmooth = 1 << 11,     ///< "smooth 0.2 s"
  kLimit = 1 << 12,      ///< "4 step", "12 ms", 0
  kTable = 1 << 13,      ///< the fields of "<table>.<key>"
  kPareto = 1 << 14,     ///< "pareto 3 ms cap 40 ms"
  kSegments = 1 << 15,   ///< "8 segments", where their length does not matter
  kAnything = 1 << 16,   ///< whatever the key that it stands for takes; checked there
};

enum class Shape { one, list, one_or_list, three };

/// In base units (s, Hz, m, N …). An open end excludes the bound itself.
struct Range {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;
};

struct Field {
  std::string_view table;  ///< "" the top, "timing", "device.motion"
  std::string_view key;    ///< "*": any key; the only row of its table
  std::uint32_t forms = 0;
  Shape shape = Shape::one;
  std::string_view default_toml = "";  ///< as written in a file; empty: none
  std::string_view meaning;
  std::string_view words = "";  ///< "fill|real"
  std::string_view kinds = "";  ///< the key exists only where `kind` of its table (kind_key) is one of these: "sine|still";
                                ///< a [timing] with a trace is of the kind "trace"
  bool required = false;
  Dimension dimension = Dimension::none;
  Range range = {};
  std::string_view example = "";  ///< a value in TOML; empty: the default, or the example of its dimension
};

const std::vector<Field>& fields();
/// The key that says which kind a table is of: "order" for [timing], "coupling" for a grab, otherwise "kind".
std::string_view kind_key(std::string_view table);
std::vector<std::string_view> split_words(std::string_view words);  // at '|'
/// The tables in the order of the field table: "", "run", "timing" …
std::vector<std::string_view> tables();
/// The table that a kTable field holds: "timing.jitter"; [[expect_append]] holds the same as [[expect]].
std::string subtable(const Field& field);
/// "[timing]", "[[device]]", "device.motion", "the top of the file"
std::string title(std::string_view table);
/// "\"fill\", \"real\" or a duration", for messages and the document.
std::string describe_forms(const Field& field);
/// "above 0 s, at most 1e6 s"; empty where there is no bound.
std::string describe_range(const Field& field);
/// A value of it as TOML.
std::string example_of(const Field& field);

}  // namespace evenstep::internal
