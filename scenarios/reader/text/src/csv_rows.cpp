#include "evenstep/text/csv_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "evenstep/text/text_file.h"

namespace evenstep::internal {

bool CsvRows::take_line() {
  if (text_.empty() && pieces_) text_ = pieces_();
  if (text_.empty()) return false;
  const std::size_t end = std::min(text_.find('\n'), text_.size());
  line_ = text_.substr(0, end);
  if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
  text_.remove_prefix(std::min(end + 1, text_.size()));
  rest_ = line_.data();
  cells_.clear();
  ++line_number_;
  return true;
}

void CsvRows::skip_remarks() {
  for (;;) {
    if (text_.empty() && pieces_) text_ = pieces_();
    if (line_number_ == 0) text_ = without_byte_order_mark(text_);
    if (!text_.starts_with('#')) return;
    take_line();
  }
}

bool CsvRows::begins_with(std::string_view header) {
  skip_remarks();
  return text_.substr(0, text_.find_first_of("\r\n")) == header;
}

bool CsvRows::header(std::string_view header) {
  skip_remarks();
  if (take_line() && line_ == header) return true;
  const std::int64_t line = std::max<std::int64_t>(line_number_, 1);
  errors_.push_back({name_, line, 1, fmt::format("the first line must be {}", header)});
  return false;
}

bool CsvRows::next() {
  if (errors_.size() >= kMostCsvErrors) return false;
  do {
    if (!take_line()) return false;
  } while (line_.empty());
  if (++rows_ <= kMostCsvRows) return true;
  errors_.push_back({name_, line_number_, 1, fmt::format("more than {} rows", kMostCsvRows)});
  return false;
}

void CsvRows::split_cells() {
  cells_.clear();
  std::string_view rest = line_;
  for (;;) {
    const std::size_t comma = rest.find(',');
    cells_.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
}

bool CsvRows::split(std::size_t count) {
  split_cells();
  if (cells_.size() == count) return true;
  errors_.push_back({name_, line_number_, 1, fmt::format("{} cells, where a row has {}", cells_.size(), count)});
  return false;
}

void CsvRows::error(std::size_t index, std::string message) {
  if (cells_.empty()) split_cells();
  errors_.push_back({name_, line_number_, cells_[index].data() - line_.data() + 1, std::move(message)});
}

bool CsvRows::whole(std::size_t index, std::int64_t& value, std::int64_t least, std::int64_t most) {
  const std::string_view text = cells_[index];
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec == std::errc{} && result.ptr == text.data() + text.size() && value >= least && value <= most) return true;
  error(index, fmt::format("'{}' is not a whole number from {} to {}", text, least, most));
  return false;
}

}  // namespace evenstep::internal
