#pragma once
/// Rows of a CSV without quotes, with the columns each cell begins at.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/harness/diagnostic.h"

namespace evenstep::internal {

inline constexpr std::int64_t kMostCsvRows = 10'000'000;
inline constexpr std::int64_t kMostCsvBytes = std::int64_t{1} << 30;  // 10 million rows of 100 bytes
inline constexpr std::size_t kMostCsvErrors = 20;                     // of one file: a wrong column is wrong in every row

class CsvRows {
 public:
  CsvRows(std::string_view text, std::string name, std::vector<Diagnostic>& errors)
      : text_(text), name_(std::move(name)), errors_(errors) {}

  /// True if the first line is `header`; adds an error otherwise.
  bool header(std::string_view header);
  /// The next line that is not empty; false at the end, after too many rows and after too many errors.
  bool next();
  /// Exactly so many cells, or an error.
  bool split(std::size_t count);
  std::string_view cell(std::size_t index) const { return cells_[index]; }
  /// An error at the cell.
  void error(std::size_t index, std::string message);
  /// A whole number >= 0 with nothing around it.
  bool whole(std::size_t index, std::int64_t& value);

 private:
  bool take_line();

  std::string_view text_, line_;
  std::string name_;
  std::vector<Diagnostic>& errors_;
  std::vector<std::string_view> cells_;
  std::int64_t line_number_ = 0;
  std::int64_t rows_ = 0;
};

}  // namespace evenstep::internal
