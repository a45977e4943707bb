#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "evenstep/reports/comparison_record.h"
#include "evenstep/reports/json.h"
#include "evenstep/reports/plain_text.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

using Change = ComparedFigure::Change;

constexpr std::size_t kMostCells = 7;
constexpr std::size_t kMostMarkdownBytes = 60'000;
constexpr std::size_t kMostMarkdownRows = 100;

/// Run, signal, metric, A, B, change, kind of change. The name of the run is left out if there is only one run.
std::vector<std::string> cells_of(const ComparisonRecord& record, const ComparedFigure& figure) {
  std::vector<std::string> cells;
  if (record.runs.size() > 1) cells.push_back(plain_text(record.runs[figure.run].name));
  std::string what = name_of(figure.change);
  for (const std::size_t condition : figure.breaks)
    what += fmt::format("; {}", plain_text(record.conditions[condition].text));
  for (const std::string& cell :
       {plain_text(figure.signal), figure_name(figure), value_a(figure), value_b(figure), change_text(figure), what})
    cells.push_back(cell);
  return cells;
}

std::vector<std::string> headings_of(const ComparisonRecord& record) {
  std::vector<std::string> headings;
  if (record.runs.size() > 1) headings.emplace_back("run");
  for (const char* const heading : {"signal", "figure", "A", "B", "change", ""}) headings.emplace_back(heading);
  return headings;
}

const char* colour_of(const ComparedFigure& figure) {
  if (!figure.breaks.empty()) return "\x1b[31m";
  switch (figure.change) {
    case Change::incomparable:
      return "\x1b[35m";
    case Change::worse:
      return "\x1b[33m";
    case Change::better:
      return "\x1b[32m";
    case Change::other:
      return "";
  }
  return "";
}

std::string table_of(const ComparisonRecord& record, const std::vector<const ComparedFigure*>& figures, bool colour) {
  std::vector<std::vector<std::string>> rows{headings_of(record)};
  for (const ComparedFigure* const figure : figures) rows.push_back(cells_of(record, *figure));
  std::array<std::size_t, kMostCells> widths{};
  for (const std::vector<std::string>& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) widths.at(c) = std::max(widths.at(c), internal::display_width(row[c]));
  }
  std::string table;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::string line;
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      const std::string padding(widths.at(c) - internal::display_width(rows[r][c]), ' ');
      const bool number = c + 4 >= rows[r].size() && c + 1 < rows[r].size();  // A, B and the change
      const bool last = c + 1 == rows[r].size();
      const bool coloured = colour && last && r > 0 && *colour_of(*figures[r - 1]) != '\0';
      if (number) line += padding;
      line += coloured ? colour_of(*figures[r - 1]) + rows[r][c] + "\x1b[0m" : rows[r][c];
      if (!last) line += (number ? "" : padding) + "  ";
    }
    line.erase(line.find_last_not_of(' ') + 1);
    table += line + '\n';
  }
  return table;
}

const char* verdict_of(const ComparedCondition& condition) { return condition.holds() ? "pass" : "FAIL"; }

Json json_of(const ComparedSide& side) {
  return {{"given", side.given},
          {"runs", side.runs},
          {"dates", side.dates},
          {"commits", side.commits},
          {"evenstep", side.versions}};
}

Json json_of(const ComparedRun& run) {
  constexpr std::array kIn{"both", "a", "b"};
  return {{"name", run.name},
          {"scenario", run.scenario},
          {"in", kIn.at(static_cast<std::size_t>(run.in))},
          {"notes", run.notes},
          {"figures", run.figures},
          {"equal", run.equal},
          {"trace_hash", run.trace_hash.empty() ? Json() : Json(run.trace_hash)}};
}

Json json_of(const ComparisonRecord& record, const ComparedFigure& figure) {
  constexpr std::array kChanges{"incomparable", "worse", "better", "other"};
  Json out = {{"run", record.runs[figure.run].name}, {"signal", figure.signal}, {"metric", figure.metric}};
  if (!figure.of.empty()) out["of"] = figure.of;
  out["unit"] = figure.unit;
  out["a"] = figure.a ? json_number(*figure.a) : Json(figure.a_word);
  out["b"] = figure.b ? json_number(*figure.b) : Json(figure.b_word);
  if (figure.has_numbers()) {
    out["difference"] = json_number(figure.difference());
    out["relative"] = json_number(figure.relative());  // null if A is 0
  }
  out["change"] = kChanges.at(static_cast<std::size_t>(figure.change));
  out["breaks"] = Json::array();
  for (const std::size_t condition : figure.breaks) out["breaks"].push_back(record.conditions[condition].text);
  return out;
}

}  // namespace

std::string comparison_text(const ComparisonRecord& record, bool colour, std::size_t most_rows, bool minor) {
  std::string text = fmt::format("A  {}\nB  {}\n", side_text(record.a), side_text(record.b));
  for (const ComparedRun& run : record.runs) {
    for (const std::string& note : run.notes) text += fmt::format("!  {}: {}\n", plain_text(run.name), plain_text(note));
  }
  std::vector<const ComparedFigure*> figures = shown_figures(record, minor);
  const std::size_t left_out = figures.size() - std::min(figures.size(), most_rows);
  figures.resize(figures.size() - left_out);
  if (!figures.empty()) text += table_of(record, figures, colour);
  if (left_out > 0) text += fmt::format("and {} more; --all shows them\n", left_out);
  for (const ComparedCondition& condition : record.conditions)
    text += fmt::format("{}  {}\n", verdict_of(condition), condition_text(condition));
  return text + fmt::format("{}: {}\n", record.holds() ? "PASS" : "FAIL", headline(record));
}

std::string comparison_markdown(const ComparisonRecord& record) {
  std::string text = fmt::format("### evenstep: {}\n\n{}\n\n- A: {}\n- B: {}\n", record.holds() ? "PASS" : "FAIL",
                                 headline(record), markdown_text(side_text(record.a)), markdown_text(side_text(record.b)));
  for (const ComparedCondition& condition : record.conditions)
    text += fmt::format("- {}: {}\n", condition.holds() ? "pass" : "**FAIL**", markdown_text(condition_text(condition)));
  const std::vector<const ComparedFigure*> figures = shown_figures(record, false);
  std::size_t written = 0;
  std::string table;
  for (const std::string& heading : headings_of(record)) table += fmt::format("| {} ", heading);
  table += "|\n";
  for (std::size_t c = 0; c < headings_of(record).size(); ++c) table += "|---";
  table += "|\n";
  for (const ComparedFigure* const figure : figures) {
    std::string line;
    for (const std::string& cell : cells_of(record, *figure)) line += fmt::format("| {} ", markdown_text(cell));
    if (written == kMostMarkdownRows || text.size() + table.size() + line.size() > kMostMarkdownBytes / 2) break;
    table += line + "|\n";
    ++written;
  }
  if (written > 0) text += "\n" + table;
  if (written < figures.size()) text += fmt::format("\nand {} more figures that differ\n", figures.size() - written);
  std::size_t silent = 0;
  std::string notes;
  for (const ComparedRun& run : record.runs) {
    for (const std::string& note : run.notes) {
      const std::string line = fmt::format("- **{}**: {}\n", markdown_text(run.name), markdown_text(note));
      if (text.size() + notes.size() + line.size() + 100 > kMostMarkdownBytes)
        ++silent;
      else
        notes += line;
    }
  }
  if (!notes.empty()) text += "\n" + notes;
  if (silent > 0) text += fmt::format("- and {} more notes\n", silent);
  return text;
}

std::string comparison_json(const ComparisonRecord& record) {
  Json out = {{"format", 1},
              {"a", json_of(record.a)},
              {"b", json_of(record.b)},
              {"holds", record.holds()},
              {"conditions", Json::array()},
              {"runs", Json::array()},
              {"figures", Json::array()}};
  for (const ComparedCondition& condition : record.conditions)
    out["conditions"].push_back({{"condition", condition.text}, {"judged", condition.judged}, {"broken", condition.broken}});
  for (const ComparedRun& run : record.runs) out["runs"].push_back(json_of(run));
  for (const ComparedFigure& figure : record.figures) out["figures"].push_back(json_of(record, figure));
  return json_text(out, "figures") + '\n';
}

}  // namespace evenstep
