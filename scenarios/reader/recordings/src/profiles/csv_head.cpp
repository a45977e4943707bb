#include "csv_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "bytes.h"
#include "column_names.h"

namespace evenstep::internal {
namespace {

constexpr std::size_t kMostLooked = std::size_t{64} << 10;
constexpr char kSeparators[] = {',', ';', '\t'};

using Cells = std::vector<std::string>;

Cells split(std::string_view line, char separator) {
  Cells cells;
  split_quoted(line, separator, cells);
  return cells;
}

bool is_comment(std::string_view line) { return line.starts_with("//") || line.starts_with('#'); }

bool are_known(const Cells& cells, const CsvColumns& given) {
  if (!given.begin.empty()) return index_of(cells, given.begin).has_value();
  return are_intervals(cells) || are_pictures(cells) || are_picture_lengths(cells);
}

/// The separator that makes the most cells of a line; a comma if several do.
char separator_of(std::string_view line) {
  char best = ',';
  for (const char separator : kSeparators) {
    if (split(line, separator).size() > split(line, best).size()) best = separator;
  }
  return best;
}

/// What a number says of the decimal sign: -1 for a point, 1 for a comma, 0 if it may be either ("1,234").
int says_of_decimal(std::string_view text) {
  const std::size_t comma = text.rfind(','), point = text.rfind('.');
  if (comma == std::string_view::npos && point == std::string_view::npos) return 0;
  if (comma != std::string_view::npos && point != std::string_view::npos) return comma > point ? 1 : -1;
  const bool is_comma = comma != std::string_view::npos;
  const std::size_t at = is_comma ? comma : point;
  const char sign = text[at];
  const std::size_t behind = text.find_first_not_of("0123456789", at + 1);
  const std::size_t digits = (behind == std::string_view::npos ? text.size() : behind) - at - 1;
  if (text.find(sign) != at) return is_comma ? -1 : 1;  // a sign that is there twice stands between thousands
  return digits == 3 ? 0 : is_comma ? 1 : -1;
}

/// The columns with times.
std::vector<std::size_t> times_of(const CsvHead& head, const CsvColumns& given) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < head.cells.size(); ++i) {
    if (head.cells[i] == given.begin || head.cells[i] == given.end || head.cells[i] == given.duration) all.push_back(i);
  }
  for (const Column& column : time_columns(head.cells)) all.push_back(column.index);
  return all;
}

char decimal_of(const CsvHead& head, const std::vector<std::string_view>& lines, const CsvColumns& given) {
  const std::vector<std::size_t> times = times_of(head, given);
  int comma = 0, point = 0;
  bool any_comma = false;
  for (std::size_t i = static_cast<std::size_t>(head.line); i < lines.size(); ++i) {
    const Cells cells = split(lines[i], head.separator);
    for (const std::size_t column : times) {
      if (column >= cells.size()) continue;
      const int says = says_of_decimal(cells[column]);
      comma += says > 0;
      point += says < 0;
      any_comma |= cells[column].find(',') != std::string::npos;
    }
  }
  if (comma != point) return comma > point ? ',' : '.';
  // Where a comma is the decimal sign, something else separates cells.
  return any_comma && head.separator != ',' ? ',' : '.';
}

}  // namespace

bool split_quoted(std::string_view line, char separator, Cells& cells) {
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
    } else if (c == separator && !quoted) {
      open_cell();
    } else {
      cell += c;
    }
  }
  cells.resize(count);
  return !quoted;
}

std::string plain_number(std::string_view text, char decimal) {
  const char between = decimal == '.' ? ',' : '.';
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (text.substr(i).starts_with("\xC2\xA0")) {  // a blank that does not break the line
      i += 1;
    } else if (text.substr(i).starts_with("\xE2\x80\xAF")) {  // a narrow one
      i += 2;
    } else if (c != between && c != ' ' && c != '\'') {
      plain += c == decimal ? '.' : c;
    }
  }
  return plain;
}

CsvHead find_csv_head(std::string_view first_bytes, const ProfileOptions& options) {
  const std::unique_ptr<Bytes> bytes = bytes_of_memory(first_bytes.substr(0, kMostLooked));
  Lines reader(*bytes);
  std::vector<std::string> kept;
  for (std::string_view line; reader.next(line);) kept.emplace_back(line);
  const std::vector<std::string_view> lines(kept.begin(), kept.end());
  CsvHead head;
  const auto take = [&](std::size_t i, char separator, std::string why) {
    head = {static_cast<std::int64_t>(i) + 1, separator, '.', split(lines[i], separator), std::move(why)};
  };
  const auto usable = [&](std::size_t i) {
    return options.header > 0 ? static_cast<std::int64_t>(i) + 1 == options.header
                              : !lines[i].empty() && !is_comment(lines[i]);
  };
  for (std::size_t i = 0; i < lines.size() && head.line == 0; ++i) {
    for (const char separator : kSeparators) {
      if (usable(i) && head.line == 0 && are_known(split(lines[i], separator), options.columns))
        take(i, separator, "its columns are known");
    }
  }
  for (std::size_t i = 0; i < lines.size() && head.line == 0; ++i) {
    const char separator = separator_of(lines[i]);
    const std::size_t count = split(lines[i], separator).size();
    if (options.header > 0 && usable(i)) take(i, separator, "--header says so");
    if (options.header == 0 && usable(i) && count > 1 && i + 1 < lines.size() &&
        split(lines[i + 1], separator).size() == count)
      take(i, separator, fmt::format("it is the first one that has as many cells ({}) as the next", count));
  }
  for (std::size_t i = 0; i < lines.size() && head.line == 0 && options.header == 0; ++i) {
    if (usable(i) && split(lines[i], separator_of(lines[i])).size() > 1)
      take(i, separator_of(lines[i]), "it is the first one that has several cells");
  }
  if (head.line > 0) head.decimal = decimal_of(head, lines, options.columns);
  return head;
}

}  // namespace evenstep::internal
