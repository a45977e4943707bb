#pragma once
/// The rows of a CSV with a header, as profilers write them. A cell in quotes may have separators and ends of lines in it.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"
#include "csv_head.h"

namespace evenstep::internal {

class CsvTable {
 public:
  /// Goes on to the line after the header.
  CsvTable(Bytes& bytes, const CsvHead& head);

  const std::vector<std::string>& header() const { return head_.cells; }
  std::optional<std::size_t> column(std::string_view name) const;
  /// "'a', 'b', 'c'": at most 40 of them.
  std::string columns_text() const;

  /// The next row that is not empty. Where the header comes again, another recording begins, with a time of its own: the
  /// rows from there on are counted, and not read.
  bool next();
  std::size_t size() const { return cells_.size(); }
  /// A row may be shorter than the header: the cell is then empty. Empty, too, for a column that is not there.
  std::string_view cell(std::optional<std::size_t> column) const {
    return column && *column < cells_.size() ? std::string_view(cells_[*column]) : std::string_view();
  }
  /// A cell with a number, as decimal_time_ns takes it.
  std::string number(std::optional<std::size_t> column) const { return plain_number(cell(column), head_.decimal); }
  std::int64_t line() const { return first_line_; }  ///< of the row, from 1
  std::int64_t rows_of_others() const { return rows_of_others_; }
  const std::string& error() const { return error_.empty() ? lines_.error() : error_; }

 private:
  bool next_row();

  CsvHead head_;
  Lines lines_;
  std::vector<std::string> cells_;
  std::string text_, error_;
  std::int64_t first_line_ = 0, rows_of_others_ = 0;
};

}  // namespace evenstep::internal
