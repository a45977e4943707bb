#pragma once
/// Reads the rows of a CSV file without quotes, and knows the column at which each cell begins. Lines before the header that
/// begin with '#' are skipped: they say where a recording comes from.

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/text/diagnostic.h"

namespace evenstep::internal {

inline constexpr std::int64_t kMostCsvRows = 10'000'000;
inline constexpr std::int64_t kMostCsvBytes = std::int64_t{1} << 30;  // 10 million rows of 100 bytes
inline constexpr std::size_t kMostCsvErrors = 20;                     // per file: a wrong column is wrong in every row

class CsvRows {
 public:
  CsvRows(std::string_view text, std::string name, std::vector<Diagnostic>& errors)
      : text_(text), name_(std::move(name)), errors_(errors) {}
  /// Takes the file in pieces of whole lines; an empty piece is the end.
  CsvRows(std::function<std::string_view()> pieces, std::string name, std::vector<Diagnostic>& errors)
      : pieces_(std::move(pieces)), name_(std::move(name)), errors_(errors) {}

  /// Whether the header is `header`. Call it before anything else is read.
  bool begins_with(std::string_view header);
  /// True if the header is `header`; adds an error otherwise.
  bool header(std::string_view header);
  /// The next line that is not empty; false at the end, after too many rows and after too many errors.
  bool next();
  /// These read the cells of a row from the left, each once, so that a good row needs a single pass. They return false if
  /// the cell is not as expected; split() and the functions below it then read the row again and say what is wrong.
  bool take_whole(std::int64_t& value) {
    if (row_done()) return false;
    const char* const first = rest_;
    std::uint64_t number = 0;  // 18 digits fit; a longer number wraps around and is refused
    for (; rest_ != line_end() && *rest_ >= '0' && *rest_ <= '9'; ++rest_)
      number = 10 * number + static_cast<std::uint64_t>(*rest_ - '0');
    value = static_cast<std::int64_t>(number);
    return rest_ - first > 0 && rest_ - first <= 18 && end_cell();
  }
  /// The same for a number that may have a minus before it.
  bool take_signed(std::int64_t& value) {
    const bool minus = !row_done() && rest_ != line_end() && *rest_ == '-';
    if (minus) ++rest_;
    if (!take_whole(value)) return false;
    if (minus) value = -value;
    return true;
  }
  bool take_word(std::string_view& word) {
    if (row_done()) return false;
    const char* const first = rest_;
    while (rest_ != line_end() && *rest_ != ',') ++rest_;
    word = {first, static_cast<std::size_t>(rest_ - first)};
    return end_cell();
  }
  /// Whether no cells are left.
  bool row_done() const { return rest_ == nullptr; }

  /// Splits the row into exactly `count` cells, or adds an error.
  bool split(std::size_t count);
  std::string_view cell(std::size_t index) const { return cells_[index]; }
  /// Adds an error at the place of a cell.
  void error(std::size_t index, std::string message);
  /// Reads a cell that must be a whole number from `least` to `most`, with nothing around it.
  bool whole(std::size_t index, std::int64_t& value, std::int64_t least = 0, std::int64_t most = INT64_MAX);

 private:
  bool take_line();
  void skip_remarks();
  void split_cells();
  const char* line_end() const { return line_.data() + line_.size(); }
  /// Moves on past the comma, or past the last cell.
  bool end_cell() {
    if (rest_ == line_end()) {
      rest_ = nullptr;
      return true;
    }
    return *rest_++ == ',';
  }

  std::function<std::string_view()> pieces_;
  std::string_view text_, line_;
  const char* rest_ = nullptr;  // the part of the row that take_... has not read yet
  std::string name_;
  std::vector<Diagnostic>& errors_;
  std::vector<std::string_view> cells_;
  std::int64_t line_number_ = 0;
  std::int64_t rows_ = 0;
};

}  // namespace evenstep::internal
