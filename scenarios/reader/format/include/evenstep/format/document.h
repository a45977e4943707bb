#pragma once
/// A TOML file as plain values that know their places in the file. toml++ nodes lose their places when they are copied (as a
/// merge must do), so toml++ is used for parsing only.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep::internal {

struct Entry;

struct Value {
  enum class Kind { boolean, integer, number, text, list, table, date };
  Kind kind = Kind::table;
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0;
  std::string text;
  std::vector<Value> list;
  std::vector<Entry> table;  ///< in the order of the file; names are unique
  Place place;

  const Value* find(std::string_view key) const;
  Value* find(std::string_view key);
  bool is(Kind k) const { return kind == k; }
};

struct Entry {
  std::string key;
  Place place;  ///< place of the key
  Value value;
};

Value text_value(std::string text, Place place);
Value integer_value(std::int64_t integer, Place place);
/// The kind in words, such as "a list", for messages.
std::string_view name_of(Value::Kind kind);
/// The value as it would be written in a file: 11.1, "30 Hz", true. For a list or table only the name of its kind.
std::string as_written(const Value& value);

class Errors {
 public:
  static constexpr std::size_t kMostErrors = 1000;
  /// Only the first kMostErrors are kept; sorted() then says how many more there were.
  void add(const Place& place, std::string message);
  /// Something that is allowed, but that may not be meant; each is kept once.
  void note(const Place& place, std::string message);
  bool any() const { return count_ > 0; }
  std::size_t count() const { return count_; }
  /// All errors by position, those of `first_file` first.
  std::vector<Diagnostic> sorted(const std::string& first_file) const;
  const std::vector<Diagnostic>& notes() const { return notes_; }

 private:
  std::vector<Diagnostic> list_, notes_;
  std::size_t count_ = 0;
};

/// Parses the text of a file into its table. Syntax errors, duplicate keys and bytes that are not UTF-8 are errors with a
/// place.
Value parse_toml(const std::string& text, const std::string& file, Errors& errors);
/// Parses one value, as it would stand after a '='. Text that is not a TOML value becomes a string, so 22.2 ms needs no
/// quotes on a command line.
Value parse_toml_value(std::string_view text, const Place& place);
/// Prints a table as TOML; parsing the result gives an equal table.
std::string print_toml(const Value& table);

}  // namespace evenstep::internal
