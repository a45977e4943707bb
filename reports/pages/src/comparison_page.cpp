#include "evenstep/pages/comparison_page.h"

#include <utility>
#include <vector>

#include "evenstep/pages/page.h"

namespace evenstep {
namespace {

constexpr std::size_t kMostRows = 5000;  // a browser shows them at once

Html conditions_of(const ComparisonRecord& record) {
  std::vector<std::vector<Html>> rows;
  for (const ComparedCondition& condition : record.conditions)
    rows.push_back({verdict_badge(condition.holds() ? "pass" : "fail"), condition_text(condition)});
  return table("What must not be so", {{"verdict"}, {"condition"}}, rows);
}

Html notes_of(const ComparisonRecord& record) {
  std::vector<std::vector<Html>> rows;
  for (const ComparedRun& run : record.runs) {
    for (const std::string& note : run.notes) rows.push_back({run.name, note});
  }
  if (rows.empty()) return {};
  return table("Why two runs are not the same thing measured twice", {{"run"}, {"note"}}, rows);
}

Html figures_of(const ComparisonRecord& record) {
  const std::vector<const ComparedFigure*> figures = shown_figures(record, true);
  std::vector<std::vector<Html>> rows;
  for (const ComparedFigure* const figure : figures) {
    if (rows.size() == kMostRows) break;
    Html what =
        figure->breaks.empty() ? Html(name_of(figure->change)) : verdict_badge("fail") + Html(" ") + name_of(figure->change);
    for (const std::size_t condition : figure->breaks) what += Html("; ") + record.conditions[condition].text;
    rows.push_back({what, record.runs[figure->run].name, figure->signal, figure_name(*figure), value_a(*figure),
                    value_b(*figure), change_text(*figure)});
  }
  Html shown = table("Figures that differ, the worst first",
                     {{"what that is"}, {"run"}, {"signal"}, {"figure"}, {"A", true}, {"B", true}, {"change", true}}, rows);
  if (rows.size() < figures.size())
    shown += element("p", std::to_string(figures.size() - rows.size()) + " more are left out");
  return rows.empty() ? Html() : shown;
}

Html runs_of(const ComparisonRecord& record) {
  std::vector<std::vector<Html>> rows;
  for (const ComparedRun& run : record.runs) {
    const char* const in = run.in == ComparedRun::In::both     ? "both"
                           : run.in == ComparedRun::In::only_a ? "only A"
                                                               : "only B";
    const std::string same = run.trace_hash.empty() ? "" : "bit-equal, trace " + run.trace_hash;
    rows.push_back({run.name, run.scenario, in, std::to_string(run.figures), std::to_string(run.equal), same});
  }
  return table("Runs", {{"run"}, {"scenario"}, {"in"}, {"figures", true}, {"equal", true}, {""}}, rows);
}

}  // namespace

std::string comparison_page(const ComparisonRecord& record, const std::string& command) {
  Page page;
  page.title = record.a.given + " → " + record.b.given;
  page.kind = "comparison";
  page.verdict = record.holds() ? "pass" : "fail";
  page.summary = element("p", headline(record)) + facts({{"A", side_text(record.a)}, {"B", side_text(record.b)}});
  page.command = command;
  page.sections = {{"conditions", "Conditions", conditions_of(record)},
                   {"notes", "Not the same", notes_of(record)},
                   {"figures", "Figures", figures_of(record)},
                   {"runs", "Runs", runs_of(record)}};
  return html_of(page);
}

}  // namespace evenstep
