#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "evenstep/reports/limit_text.h"
#include "evenstep/reports/writers.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

constexpr std::size_t kColumnCount = 7;
using Row = std::array<std::string, kColumnCount>;
constexpr std::size_t kVerdict = 5;
constexpr std::array<bool, kColumnCount> kRight{false, false, true, false, true, false, false};

Row row_of(const ExpectationResult& result) {
  return {result.signal,
          result.metric,
          value_text(result),
          limit_text(result),
          margin_text(result),
          verdict_text(result),
          fmt::format("{}:{}", result.file, result.line)};
}

const char* colour_of(ExpectationResult::Verdict verdict) {
  switch (verdict) {
    case ExpectationResult::Verdict::skipped:
      return "\x1b[90m";
    case ExpectationResult::Verdict::pass:
      return "\x1b[32m";
    case ExpectationResult::Verdict::degraded:
      return "\x1b[33m";
    case ExpectationResult::Verdict::fail:
      return "\x1b[31m";
    case ExpectationResult::Verdict::error:
      return "\x1b[35m";
  }
  return "";
}

/// Text of a scenario is printed on a terminal, so control characters (which may start an escape sequence) become '?'.
std::string printable(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  return text;
}

std::string line_of(const Row& row, const std::array<std::size_t, kColumnCount>& widths, const char* colour) {
  std::string line;
  for (std::size_t c = 0; c < kColumnCount; ++c) {
    const std::string padding(widths[c] - internal::display_width(row[c]), ' ');
    const bool coloured = colour && c == kVerdict;
    if (kRight[c]) line += padding;
    line += coloured ? colour + row[c] + "\x1b[0m" : row[c];
    if (c + 1 == kColumnCount) break;
    line += (kRight[c] ? "" : padding) + "  ";
  }
  return line + '\n';
}

}  // namespace

std::string verdict_table(const std::vector<ExpectationResult>& results, bool colour) {
  std::vector<Row> rows{{"signal", "metric", "value", "limit", "margin", "verdict", "where"}};
  for (const ExpectationResult& result : results) rows.push_back(row_of(result));
  std::array<std::size_t, kColumnCount> widths{};
  for (Row& row : rows) {
    for (std::size_t c = 0; c < kColumnCount; ++c) {
      row[c] = printable(std::move(row[c]));
      widths[c] = std::max(widths[c], internal::display_width(row[c]));
    }
  }
  std::string table = line_of(rows[0], widths, nullptr);
  for (std::size_t i = 0; i < results.size(); ++i) {
    table += line_of(rows[i + 1], widths, colour ? colour_of(results[i].verdict) : nullptr);
    if (results[i].verdict <= ExpectationResult::Verdict::pass) continue;
    if (!results[i].detail.empty()) table += "    " + printable(results[i].detail) + '\n';
    if (!results[i].where.empty()) table += "    " + printable(results[i].where) + '\n';
    if (!results[i].because.empty()) table += "    because: " + printable(results[i].because) + '\n';
  }
  return table;
}

}  // namespace evenstep
