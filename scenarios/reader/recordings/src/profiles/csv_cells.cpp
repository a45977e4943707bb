#include "csv_cells.h"

#include <algorithm>

namespace evenstep::internal {

void split_quoted(std::string_view line, std::vector<std::string>& cells) {
  std::size_t count = 0;
  bool quoted = false;
  const auto open_cell = [&] {
    if (count == cells.size()) cells.emplace_back();
    cells[count++].clear();
  };
  open_cell();
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    std::string& cell = cells[count - 1];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cell += line[++i];
    } else if (c == '"' && (quoted || cell.empty())) {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      open_cell();
    } else {
      cell += c;
    }
  }
  cells.resize(count);
}

CsvTable::CsvTable(Bytes& bytes) : lines_(bytes) {
  std::string_view line;
  while (lines_.next(line)) {
    if (line.empty() || line.starts_with("//") || line.starts_with('#') || line.find(',') == std::string_view::npos)
      continue;
    split_quoted(line, header_);
    return;
  }
}

std::optional<std::size_t> CsvTable::column(std::string_view name) const {
  if (name.empty()) return std::nullopt;
  const auto found = std::find(header_.begin(), header_.end(), name);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

std::string CsvTable::columns_text() const {
  constexpr std::size_t kMostShown = 40;
  std::string text;
  for (std::size_t i = 0; i < std::min(header_.size(), kMostShown); ++i)
    text += (i == 0 ? "'" : ", '") + header_[i].substr(0, 60) + "'";
  return header_.size() > kMostShown ? text + " and more" : text;
}

bool CsvTable::next() {
  std::string_view line;
  while (lines_.next(line)) {
    if (line.empty()) continue;
    split_quoted(line, cells_);
    return true;
  }
  return false;
}

}  // namespace evenstep::internal
