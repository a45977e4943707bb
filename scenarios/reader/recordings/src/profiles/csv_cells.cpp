#include "csv_cells.h"

#include <fmt/format.h>

#include <algorithm>

#include "column_names.h"

namespace evenstep::internal {

CsvTable::CsvTable(Bytes& bytes, const CsvHead& head) : head_(head), lines_(bytes) {
  std::string_view line;
  while (lines_.number() < head.line && lines_.next(line)) {
  }
  first_line_ = lines_.number();
}

std::optional<std::size_t> CsvTable::column(std::string_view name) const {
  return name.empty() ? std::nullopt : index_of(header(), name);
}

std::string CsvTable::columns_text() const {
  constexpr std::size_t kMostShown = 40;
  std::string text;
  for (std::size_t i = 0; i < std::min(header().size(), kMostShown); ++i)
    text += (i == 0 ? "'" : ", '") + header()[i].substr(0, 60) + "'";
  return header().size() > kMostShown ? text + " and more" : text;
}

bool CsvTable::next_row() {
  std::string_view line;
  do {
    if (!lines_.next(line)) return false;
  } while (line.empty());
  first_line_ = lines_.number();
  if (split_quoted(line, head_.separator, cells_)) return true;
  constexpr int kMostLines = 100;
  text_ = line;
  for (int i = 1; i < kMostLines && lines_.next(line) && text_.size() < kLongestProfileLine; ++i) {
    text_ += '\n';
    text_ += line;
    if (line.find('"') != std::string_view::npos && split_quoted(text_, head_.separator, cells_)) return true;
  }
  if (error().empty())
    error_ = fmt::format("line {}: a quote that is opened there is not closed within {} lines and {} bytes", first_line_,
                         kMostLines, kLongestProfileLine);
  return false;
}

bool CsvTable::next() {
  if (!next_row()) return false;
  if (cells_ != head_.cells) return true;
  while (next_row()) rows_of_others_ += cells_ != head_.cells;
  return false;
}

}  // namespace evenstep::internal
