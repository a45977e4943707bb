#pragma once
/// The rows of a CSV with a header, whose cells may be quoted, as profilers write them.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bytes.h"

namespace evenstep::internal {

/// Splits a line at its commas. "" within quotes is a quote; a quote that is not closed reaches to the line's end.
void split_quoted(std::string_view line, std::vector<std::string>& cells);

class CsvTable {
 public:
  /// Goes on to the header: the first line that is neither empty nor a comment of a tool ("//…", "#…") and has a comma.
  explicit CsvTable(Bytes& bytes);

  const std::vector<std::string>& header() const { return header_; }
  std::optional<std::size_t> column(std::string_view name) const;
  /// "'a', 'b', 'c'": at most 40 of them.
  std::string columns_text() const;

  /// The next row that is not empty.
  bool next();
  std::size_t size() const { return cells_.size(); }
  /// A row may be shorter than the header: the cell is then empty. Empty, too, for a column that is not there.
  std::string_view cell(std::optional<std::size_t> column) const {
    return column && *column < cells_.size() ? std::string_view(cells_[*column]) : std::string_view();
  }
  std::int64_t line() const { return lines_.number(); }
  const std::string& error() const { return lines_.error(); }

 private:
  Lines lines_;
  std::vector<std::string> header_, cells_;
};

}  // namespace evenstep::internal
