// Phrases that the terminal, Markdown and the page share.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "evenstep/reports/comparison_record.h"
#include "evenstep/reports/plain_text.h"

namespace evenstep {
namespace {

constexpr std::size_t kShortCommit = 12;

struct Prefix {
  double factor;
  std::string_view name;
};

/// The prefix with which the value, rounded to six digits, has one to three of them before the point.
Prefix prefix_of(double value, std::string_view unit) {
  constexpr std::array kPrefixes = std::to_array<Prefix>({{1, ""}, {1e-3, "m"}, {1e-6, "u"}, {1e-9, "n"}});
  if (unit != "m" && unit != "s" && unit != "N" && unit != "J") return kPrefixes.front();
  if (std::abs(value) < 1e-10) return kPrefixes.front();  // "1.6e-15 N": rounding, not nanonewtons
  for (const Prefix& prefix : kPrefixes) {
    if (std::abs(value) >= prefix.factor * (1 - 5e-7)) return prefix;
  }
  return kPrefixes.back();
}

std::string with_unit(double value, std::string_view unit, bool sign) {
  const Prefix prefix = prefix_of(value, unit);
  const std::string number =
      sign ? fmt::format("{:+.6g}", value / prefix.factor) : fmt::format("{:.6g}", value / prefix.factor);
  return unit.empty() || unit == "1" || unit == "count" ? number : fmt::format("{} {}{}", number, prefix.name, unit);
}

std::string counted(std::size_t count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// The only string, or the first and the last.
std::string span_of(const std::vector<std::string>& sorted) {
  return sorted.size() == 1 ? sorted.front() : sorted.front() + " to " + sorted.back();
}

}  // namespace

double ComparedFigure::relative() const {
  return *a == 0 ? std::copysign(std::numeric_limits<double>::infinity(), *b) : difference() / std::abs(*a);
}

bool ComparisonRecord::holds() const {
  return std::all_of(conditions.begin(), conditions.end(), [](const ComparedCondition& c) { return c.holds(); });
}

std::string value_a(const ComparedFigure& figure) {
  return figure.a ? with_unit(*figure.a, figure.unit, false) : plain_text(figure.a_word);
}
std::string value_b(const ComparedFigure& figure) {
  return figure.b ? with_unit(*figure.b, figure.unit, false) : plain_text(figure.b_word);
}

std::string change_text(const ComparedFigure& figure) {
  if (!figure.has_numbers()) return "";
  const std::string absolute = with_unit(figure.difference(), figure.unit, true);
  if (*figure.a == 0) return absolute;
  return fmt::format("{}, {:+.3g} %", absolute, 100 * figure.relative());
}

const char* name_of(ComparedFigure::Change change) {
  constexpr std::array kNames{"cannot be compared", "worse", "better", "changed"};
  return kNames.at(static_cast<std::size_t>(change));
}

std::string figure_name(const ComparedFigure& figure) {
  return plain_text(figure.of.empty() ? figure.metric : figure.metric + " of " + figure.of);
}

std::string side_text(const ComparedSide& side) {
  std::string text = fmt::format("{}: {}", plain_text(side.given), counted(side.runs, "run"));
  text += side.dates.empty() ? ", no date" : ", " + plain_text(span_of(side.dates));
  if (side.commits.empty())
    text += ", no commit";
  else if (side.commits.size() == 1)
    text += ", commit " + plain_text(side.commits.front().substr(0, kShortCommit));
  else
    text += fmt::format(", {} commits", side.commits.size());
  if (!side.versions.empty()) text += ", evenstep " + plain_text(span_of(side.versions));
  return text;
}

std::string condition_text(const ComparedCondition& condition) {
  const std::string text = plain_text(condition.text);
  if (condition.judged == 0) return text + ": there is no figure that it could judge";
  if (condition.broken == 0) return fmt::format("{}: not so in {}", text, counted(condition.judged, "figure"));
  return fmt::format("{}: so in {} of {}", text, condition.broken, counted(condition.judged, "figure"));
}

std::string headline(const ComparisonRecord& record) {
  std::size_t broken = 0, figures = 0, equal = 0, same_runs = 0;
  for (const ComparedCondition& condition : record.conditions) broken += condition.holds() ? 0 : 1;
  for (const ComparedRun& run : record.runs) {
    figures += run.figures;
    equal += run.equal;
    same_runs += run.trace_hash.empty() ? 0 : 1;
  }
  std::array<std::size_t, 4> changed{};
  for (const ComparedFigure* const figure : shown_figures(record, false))
    ++changed.at(static_cast<std::size_t>(figure->change));
  std::string text = broken > 0 ? fmt::format("{} of {} broken", broken, counted(record.conditions.size(), "condition"))
                                : "no condition broken";
  text += fmt::format("; {} worse, {} better, {} changed, {} not comparable; {} of {} equal to the last bit", changed[1],
                      changed[2], changed[3], changed[0], equal, counted(figures, "figure"));
  if (same_runs > 0) text += fmt::format("; {} bit-equal in all", counted(same_runs, "run"));
  return text;
}

std::vector<const ComparedFigure*> shown_figures(const ComparisonRecord& record, bool minor) {
  std::vector<const ComparedFigure*> shown;
  for (const ComparedFigure& figure : record.figures) {
    if (minor || !figure.minor || !figure.breaks.empty()) shown.push_back(&figure);
  }
  return shown;
}

}  // namespace evenstep
