#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include "evenstep/pages/campaign_pages.h"
#include "evenstep/pages/page.h"

namespace evenstep {
namespace {

/// What share of the points passed, as a bar with the number beside it.
Html share_bar(const SweepTally& tally) {
  if (tally.runs() == 0) return "not run";
  const double share = static_cast<double>(tally.passed) / static_cast<double>(tally.runs());
  constexpr double kWidth = 144;
  std::string svg = fmt::format("<svg class=\"margin\" viewBox=\"0 0 {:g} 14\" aria-hidden=\"true\">", kWidth);
  svg += fmt::format("<rect class=\"holds\" x=\"0\" y=\"3\" width=\"{:g}\" height=\"8\"/>", kWidth);
  svg += fmt::format("<rect class=\"good\" x=\"0\" y=\"3\" width=\"{:.1f}\" height=\"8\"/></svg>", share * kWidth);
  return Html::markup(svg);
}

std::vector<Html> tally_row(const Html& name, const SweepTally& tally) {
  const std::string rate = tally.runs() > 0 ? fmt::format("{:.3g} %", 100 * tally.failure_rate_at_most()) : "";
  return {name,
          share_bar(tally),
          fmt::format("{}", tally.passed),
          fmt::format("{}", tally.failed),
          fmt::format("{}", tally.errors),
          rate};
}

const std::vector<Column> kTallyColumns{{"value"},        {"share"},        {"passed", true},
                                        {"failed", true}, {"errors", true}, {"failure rate at most (95 %)", true}};

Html axes(const SweepHeader& header, const SweepSummary& summary) {
  Html body;
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis) {
    std::vector<std::vector<Html>> rows;
    for (std::size_t i = 0; i < summary.values[axis].size(); ++i)
      rows.push_back(tally_row(shown_value(header.grid[axis].values[i]), summary.values[axis][i]));
    body += table(header.grid[axis].path, kTallyColumns, rows);
  }
  return body;
}

std::string values_of(const SweepHeader& header, const SweepPoint& point) {
  std::string text;
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis)
    text += fmt::format("{}{} {}", axis > 0 ? ", " : "", header.grid[axis].path,
                        shown_value(header.grid[axis].values[header.value_of(point.index, axis)]));
  if (!header.swarm.empty())
    text += fmt::format("{}faults: {}", text.empty() ? "" : "; ",
                        point.faults_on.empty() ? "none" : fmt::format("{}", fmt::join(point.faults_on, ", ")));
  return text;
}

Html worst_points(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command) {
  if (summary.worst.empty()) return {};
  std::vector<std::vector<Html>> rows;
  for (const SweepSummary::Worst& worst : summary.worst) {
    const SweepPoint& point = worst.point;
    Html why = point.failure;
    if (worst.expectation && point.expect[*worst.expectation].value) {
      const SweepHeader::Expect& expect = header.expectations[*worst.expectation];
      why = element("code", expect.signal) +
            fmt::format(" {} {:.6g} {}", expect.metric, *point.expect[*worst.expectation].value, expect.unit);
    }
    rows.push_back({verdict_badge(name_of(point.verdict)), fmt::format("{}", header.seed_of(point.index)),
                    values_of(header, point), why, element("code", command(point))});
  }
  return table("The points that exceed their limits by most, or stopped; each with the command that runs it again.",
               {{"verdict"}, {"seed", true}, {"values"}, {"what"}, {"again"}}, rows);
}

Html found(const SweepHeader& header, const SweepSummary& summary) {
  if (!summary.find || !header.find) return {};
  const SweepHeader::Axis& axis = header.grid[header.find->axis];
  const char* const word = header.find->smallest ? "smallest" : "largest";
  if (!summary.find->value) return element("p", fmt::format("The {} {} that passes for every seed: none.", word, axis.path));
  Html text = element("p", fmt::format("The {} {} that passes for every seed: ", word, axis.path) +
                               element("strong", shown_value(axis.values[*summary.find->value])));
  if (!header.find->gate.empty())
    text +=
        element("p", fmt::format("{} {} was asked for.", header.find->smallest ? "At most" : "At least", header.find->gate));
  return text;
}

Html states(const SweepHeader& header, const SweepSummary& summary) {
  if (header.sometimes.empty()) return {};
  std::vector<std::vector<Html>> rows;
  for (std::size_t i = 0; i < header.sometimes.size(); ++i) {
    const auto& [name, signal, metric] = header.sometimes[i];
    const char* const verdict = !summary.complete ? "skipped" : summary.reached[i] > 0 ? "pass" : "fail";
    rows.push_back({verdict_badge(verdict), name, element("code", signal) + fmt::format(" {}", metric),
                    fmt::format("{} of {}", summary.reached[i], summary.all.runs())});
  }
  const char* const caption = summary.complete
                                  ? "States that at least one point must reach."
                                  : "States that at least one point must reach; not judged, because that takes all points.";
  return table(caption, {{"verdict"}, {"state"}, {"what"}, {"points", true}}, rows);
}

/// The states that no point reached, which fail a sweep whatever its points did; empty if all were, or this is not known.
Html unreached(const SweepHeader& header, const SweepSummary& summary) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < header.sometimes.size() && summary.complete; ++i) {
    if (summary.reached[i] == 0) names.push_back(header.sometimes[i].name);
  }
  if (names.empty()) return {};
  return element("p", fmt::format("No point reached {} of {} states, so the sweep does not test what it is meant to: {}.",
                                  names.size(), header.sometimes.size(), fmt::join(names, "; ")));
}

/// The same of expectations that no point judged.
Html unjudged(const SweepHeader& header, const SweepSummary& summary) {
  Html all;
  for (std::size_t i = 0; i < summary.judged.size() && summary.complete; ++i) {
    if (summary.judged[i] > 0) continue;
    all += element("p", fmt::format("No point judged {} {}, as it applied to none.", header.expectations[i].signal,
                                    header.expectations[i].metric));
  }
  return all;
}

}  // namespace

std::string sweep_page(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command,
                       const std::string& verdict, const std::string& reproduce) {
  Html outcome = element("p", fmt::format("{} of {} points passed, {} failed, {} had errors.", summary.all.passed,
                                          summary.all.runs(), summary.all.failed, summary.all.errors));
  if (summary.stopped)
    outcome += element("p", fmt::format("It stopped early, after {} of {} points.", summary.all.runs(), header.points()));
  outcome += found(header, summary) + unreached(header, summary) + unjudged(header, summary) +
             element("p", {{"class", "quiet"}}, element("code", header.file));
  Page page{header.name, "evenstep sweep", verdict, outcome, reproduce, {}, ""};
  const Html all = table("All points", kTallyColumns, {tally_row("all", summary.all)});
  page.sections = {{"values", "Values", all + axes(header, summary)}};
  if (!header.sometimes.empty()) page.sections.push_back({"states", "States", states(header, summary)});
  page.sections.push_back({"worst", "Worst points", worst_points(header, summary, command)});
  page.sections.push_back({"environment", "Environment",
                           facts({{"seeds", fmt::format("{}", header.seeds.size())},
                                  {"digest of the scenario", element("code", header.scenario)},
                                  {"digest of the program", element("code", header.build)}})});
  return html_of(page);
}

}  // namespace evenstep
