// The decade strip: every cell of a case, failures included, as text and as a picture.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "evenstep/reports/case_record.h"
#include "writers/figures/svg.h"

namespace evenstep {
namespace {

/// The text in a cell, so that colour is never the only information.
std::string cell_text(const CaseCell& cell) {
  switch (cell.status) {
    case CellStatus::ok:
      return "ok";
    case CellStatus::damped:
      return fmt::format("x{:.2g}", cell.shown.value_or(0));
    case CellStatus::drifting:
      return fmt::format("~{:.2g}", cell.shown.value_or(0));
    case CellStatus::refused:
      return "refused";
    case CellStatus::diverged:
      return fmt::format("@{}", cell.steps);
    case CellStatus::unavailable:
      return "-";
    case CellStatus::interrupted:
      return "not run";
  }
  return "";
}

struct Look {
  CellStatus status;
  const char* fill;
  const char* text;
  const char* legend;
};
constexpr std::array kLooks = std::to_array<Look>({
    {CellStatus::ok, internal::colour::kGreen, "#ffffff", "ok"},
    {CellStatus::damped, internal::colour::kOrange, "#000000", "x: damped, energy left"},
    {CellStatus::drifting, internal::colour::kOrange, "#000000", "~: drifting, error"},
    {CellStatus::refused, internal::colour::kVermilion, "#ffffff", "refused by the solver"},
    {CellStatus::diverged, internal::colour::kBlack, "#ffffff", "@: diverged, first bad step"},
    {CellStatus::unavailable, "#bbbbbb", "#000000", "-: not there"},
    {CellStatus::interrupted, "#eeeeee", "#000000", "interrupted"},
});

const Look& look_of(CellStatus status) {
  return *std::find_if(kLooks.begin(), kLooks.end(), [&](const Look& look) { return look.status == status; });
}

std::string value_text(double value) { return fmt::format("{:.5g}", value); }

std::string value_label(const CaseRecord& record) {
  return record.value_unit.empty() ? record.value_name : fmt::format("{} [{}]", record.value_name, record.value_unit);
}

constexpr double kNamesWidth = 250, kCellWidth = 64, kCellHeight = 26, kTop = 74, kLegend = 150;

}  // namespace

std::string case_table(const CaseRecord& record) {
  std::size_t names = value_label(record).size(), width = 7;
  for (const CaseRow& row : record.rows) {
    names = std::max(names, row.method.size() + 1 + row.solver.size());
    for (const CaseCell& cell : row.cells) width = std::max({width, cell_text(cell).size(), value_text(cell.value).size()});
  }
  std::string table;
  const auto line = [&](const std::string& name, const auto& text_of, const std::vector<CaseCell>& cells) {
    table += fmt::format("{:<{}}", name, names);
    for (const CaseCell& cell : cells) table += fmt::format("  {:>{}}", text_of(cell), width);
    table += '\n';
  };
  if (record.rows.empty()) return table;
  line(
      value_label(record), [](const CaseCell& cell) { return value_text(cell.value); }, record.rows.front().cells);
  for (const CaseRow& row : record.rows) line(row.method + " " + row.solver, cell_text, row.cells);
  return table + "x: damped, energy left; ~: drifting, error; @: diverged, first bad step; -: not there\n";
}

std::string case_strip_svg(const CaseRecord& record, const std::string& title) {
  using internal::Svg;
  const std::size_t columns = record.rows.empty() ? 0 : record.rows.front().cells.size();
  const double width = std::max(kNamesWidth + kCellWidth * static_cast<double>(columns) + 16, 6 * kLegend + 40);
  Svg svg(width, kTop + kCellHeight * static_cast<double>(record.rows.size()) + 44, title);
  svg.text({16, kTop - 10}, value_label(record), Svg::Anchor::start, 12, true);
  for (std::size_t c = 0; c < columns; ++c) {
    svg.text({kNamesWidth + kCellWidth * (static_cast<double>(c) + 0.5), kTop - 10},
             value_text(record.rows.front().cells[c].value), Svg::Anchor::middle, 11);
  }
  double top = kTop;
  for (const CaseRow& row : record.rows) {
    svg.text({16, top + 17}, row.method + "  " + row.solver);
    for (std::size_t c = 0; c < row.cells.size(); ++c) {
      const Look& look = look_of(row.cells[c].status);
      const double left = kNamesWidth + kCellWidth * static_cast<double>(c);
      svg.rect({left + 1, top + 1, left + kCellWidth - 1, top + kCellHeight - 1}, look.fill, look.fill);
      svg.text({left + kCellWidth / 2, top + 17}, cell_text(row.cells[c]), Svg::Anchor::middle, 11, false, look.text);
    }
    top += kCellHeight;
  }
  double left = 16;
  for (const Look& look : kLooks) {
    svg.rect({left, top + 16, left + 12, top + 28}, look.fill, look.fill);
    svg.text({left + 17, top + 26}, look.legend, Svg::Anchor::start, 11);
    left += kLegend + (look.status == CellStatus::diverged ? 20 : 0) - (look.status == CellStatus::ok ? 90 : 0);
  }
  return std::move(svg).finish();
}

}  // namespace evenstep
