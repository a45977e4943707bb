#include "evenstep/pages/index_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <tuple>

#include "evenstep/pages/page.h"

namespace evenstep {
namespace {

constexpr double kWidth = 160, kHeight = 32, kEdge = 4;  // of a trend, px
constexpr std::size_t kMostPoints = 100;                 // of a trend: the latest

using Runs = std::vector<const IndexedRun*>;

std::string percent(double share) { return fmt::format("{:.3g} %", 100 * share); }

/// A link relative to the page's folder: no name can turn it into one with a scheme or a host.
std::string address(const std::string& path) {
  std::string out = "./";
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
                       c == '.' || c == '/';
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

/// A line of the worst margins, drawn between -100 % and 100 % or less; a point for each run that did not pass.
Html trend(Runs runs) {
  if (runs.size() > kMostPoints) runs.erase(runs.begin(), runs.end() - kMostPoints);
  const auto shown = [](double margin) { return std::clamp(margin, -1.0, 1.0); };
  double low = 0, high = 0;
  for (const IndexedRun* const run : runs) {
    if (run->margin) low = std::min(low, shown(*run->margin)), high = std::max(high, shown(*run->margin));
  }
  const double span = high > low ? high - low : 1;
  const double step = (kWidth - 2 * kEdge) / static_cast<double>(std::max<std::size_t>(1, runs.size() - 1));
  const auto y_of = [&](double margin) { return kEdge + (kHeight - 2 * kEdge) * (high - shown(margin)) / span; };
  Html marks = element("line", {{"x1", "0"},
                                {"x2", fmt::format("{}", kWidth)},
                                {"y1", fmt::format("{:.1f}", y_of(0))},
                                {"y2", fmt::format("{:.1f}", y_of(0))},
                                {"stroke", "currentColor"},
                                {"stroke-opacity", "0.3"}});
  std::string points;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const double x = kEdge + step * static_cast<double>(i), y = y_of(runs[i]->margin.value_or(0));
    if (runs[i]->margin) points += fmt::format("{}{:.1f},{:.1f}", points.empty() ? "" : " ", x, y);
    if (runs[i]->verdict != "pass") {
      const std::string cross = fmt::format("M{:.1f},{:.1f} l6,6 m0,-6 l-6,6", x - 3, y - 3);
      marks += element("path", {{"d", cross}, {"stroke", "#d55e00"}, {"stroke-width", "2"}});
    } else if (runs.size() == 1) {
      marks += element(
          "circle",
          {{"cx", fmt::format("{:.1f}", x)}, {"cy", fmt::format("{:.1f}", y)}, {"r", "3"}, {"fill", "currentColor"}});
    }
  }
  marks += element("polyline", {{"points", points}, {"fill", "none"}, {"stroke", "currentColor"}, {"stroke-width", "1.5"}});
  const std::string label = fmt::format("worst margin of {} runs, from {} to {}", runs.size(),
                                        runs.front()->margin ? percent(*runs.front()->margin) : "none",
                                        runs.back()->margin ? percent(*runs.back()->margin) : "none");
  return element("svg",
                 {{"width", fmt::format("{}", kWidth)},
                  {"height", fmt::format("{}", kHeight)},
                  {"viewBox", fmt::format("0 0 {} {}", kWidth, kHeight)},
                  {"role", "img"},
                  {"aria-label", label}},
                 element("title", label) + marks);
}

Html margin_of(const IndexedRun& run) { return run.margin ? Html(percent(*run.margin)) : Html("–"); }

Html link_to(const IndexedRun& run) { return element("a", {{"href", address(run.link)}}, run.name); }

Html scenarios_of(const std::map<std::string, Runs>& by_file) {
  std::vector<std::vector<Html>> rows;
  for (const auto& [file, runs] : by_file) {
    const IndexedRun& latest = *runs.back();
    rows.push_back({latest.scenario, verdict_badge(latest.verdict), margin_of(latest), latest.margin_of, trend(runs),
                    std::to_string(runs.size()), link_to(latest)});
  }
  return table("The latest run of each scenario; a cross in the trend is a run that did not pass",
               {{"scenario"}, {"verdict"}, {"worst margin", true}, {"of"}, {"trend"}, {"runs", true}, {"latest"}}, rows);
}

Html runs_of(Runs runs) {
  std::reverse(runs.begin(), runs.end());
  std::vector<std::vector<Html>> rows;
  for (const IndexedRun* const run : runs)
    rows.push_back({run->date.empty() ? "no date" : run->date, run->scenario, verdict_badge(run->verdict), margin_of(*run),
                    run->margin_of, run->commit.empty() ? Html("none") : element("code", run->commit.substr(0, 12)),
                    link_to(*run)});
  return table("All runs, the latest first",
               {{"date"}, {"scenario"}, {"verdict"}, {"worst margin", true}, {"of"}, {"commit"}, {"run"}}, rows);
}

}  // namespace

std::string index_page(const std::string& folder, const std::vector<IndexedRun>& runs, const std::string& command) {
  Runs ordered;
  for (const IndexedRun& run : runs) ordered.push_back(&run);
  std::sort(ordered.begin(), ordered.end(), [](const IndexedRun* a, const IndexedRun* b) {
    return std::tie(a->date, a->name) < std::tie(b->date, b->name);
  });
  std::map<std::string, Runs> by_file;
  for (const IndexedRun* const run : ordered) by_file[run->file].push_back(run);
  std::size_t passing = 0;
  for (const auto& [file, its_runs] : by_file) passing += its_runs.back()->verdict == "pass" ? 1 : 0;
  Page page;
  page.title = folder;
  page.kind = kIndexKind;
  page.verdict = passing == by_file.size() ? "pass" : "fail";
  page.summary = element("p", fmt::format("{} runs of {} scenarios; the latest run of {} of them passes", runs.size(),
                                          by_file.size(), passing));
  page.command = command;
  page.sections = {{"scenarios", "Scenarios", scenarios_of(by_file)}, {"runs", "Runs", runs_of(ordered)}};
  return html_of(page);
}

}  // namespace evenstep
