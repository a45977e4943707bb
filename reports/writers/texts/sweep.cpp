#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11

#include <algorithm>
#include <cmath>
#include <iterator>

#include "evenstep/reports/json.h"
#include "evenstep/reports/sweep_record.h"
#include "writers/texts/text.h"

namespace evenstep {
namespace {

std::string tally_cells(const SweepTally& tally) {
  if (tally.runs() == 0) return "not run";
  return fmt::format("{:>9} {:>9} {:>9}   {:.3g} %", tally.passed, tally.failed, tally.errors,
                     100 * tally.failure_rate_at_most());
}

std::string values_of(const SweepHeader& header, const SweepPoint& point) {
  std::string text = fmt::format("seed {}", header.seed_of(point.index));
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis) {
    const SweepHeader::Axis& one = header.grid[axis];
    text += fmt::format(", {} {}", one.path, shown_value(one.values[header.value_of(point.index, axis)]));
  }
  if (header.swarm.empty()) return text;
  return text + (point.faults_on.empty() ? ", no fault" : fmt::format(", faults {}", fmt::join(point.faults_on, " ")));
}

std::string with_unit(double number, const std::string& unit) {
  return unit.empty() ? fmt::format("{:.6g}", number) : fmt::format("{:.6g} {}", number, unit);
}

/// "left.force.paper underruns 3, limit 0"
std::string reason(const SweepHeader& header, const SweepPoint& point, const SweepSummary::Worst& worst) {
  if (!worst.expectation) return point.failure.empty() ? "nothing to compare" : point.failure;
  const SweepPoint::Value& judged = point.expect[*worst.expectation];
  const SweepHeader::Expect& expect = header.expectations[*worst.expectation];
  if (!judged.value) return fmt::format("{} {}: {}", expect.signal, expect.metric, point.failure);
  const bool over = judged.max && (!judged.min || *judged.value > (*judged.min + *judged.max) / 2);
  return fmt::format("{} {} {}, {} {}", expect.signal, expect.metric, with_unit(*judged.value, expect.unit),
                     over ? "max" : "min", with_unit(over ? *judged.max : *judged.min, expect.unit));
}

std::string find_text(const SweepHeader& header, const SweepSummary::Find& found) {
  const SweepHeader::Find& wanted = *header.find;
  const SweepHeader::Axis& axis = header.grid[wanted.axis];
  const std::string_view word = wanted.smallest ? "smallest" : "largest", beyond = wanted.smallest ? "smaller" : "larger";
  if (!found.value) {
    std::string text = fmt::format("{} {}: none, since {} does not pass for every seed\n", word, axis.path,
                                   shown_value(wanted.smallest ? axis.values.back() : axis.values.front()));
    if (found.beyond > 0)
      text += fmt::format("  {} {} values pass, but a value at the safe end fails\n", found.beyond, beyond);
    return text;
  }
  std::string text = fmt::format("{} {}: {}", word, axis.path, shown_value(axis.values[*found.value]));
  const std::string_view gate = wanted.smallest ? "at most" : "at least";
  if (!wanted.gate.empty())
    text += found.within_gate ? fmt::format(" ({} {} asked for)", gate, wanted.gate)
                              : fmt::format(", but {} {} is asked for", gate, wanted.gate);
  text += '\n';
  if (found.beyond > 0)
    text += fmt::format("  not monotone: {} {} value{} pass{} too, with a failure in between\n", found.beyond, beyond,
                        found.beyond == 1 ? "" : "s", found.beyond == 1 ? "es" : "");
  return text;
}

std::string state_text(const SweepHeader& header, const SweepSummary& summary) {
  if (header.sometimes.empty()) return "";
  std::string text = "states\n";
  for (std::size_t i = 0; i < header.sometimes.size(); ++i) {
    const auto& [name, signal, metric] = header.sometimes[i];
    text += fmt::format("  {:>9} of {} points: {}\n", summary.reached[i], summary.all.runs(), name);
    if (summary.reached[i] == 0 && summary.complete)
      text += fmt::format(
          "            error: no point reached it ({} {}): the sweep does not test what it is meant to; give "
          "it more seeds, other values, or remove the state\n",
          signal, metric);
  }
  if (!summary.complete) text += "  not judged: that takes all points\n";
  return text;
}

/// The expectations that a complete sweep judged in none of its points.
std::vector<std::string> unjudged(const SweepHeader& header, const SweepSummary& summary) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < summary.judged.size() && summary.complete; ++i) {
    const SweepHeader::Expect& expectation = header.expectations[i];
    if (summary.judged[i] == 0) names.push_back(expectation.signal + ' ' + expectation.metric);
  }
  return names;
}

std::string unjudged_text(const std::string& expectation) {
  return fmt::format(
      "no point judged {}, as it applied to none: the sweep does not test what it is meant to; give it more "
      "seeds, or remove the expectation",
      expectation);
}

void put_tally(Json& out, const SweepTally& tally) {
  out["points"] = tally.runs();
  out["passed"] = tally.passed;
  out["failed"] = tally.failed;
  out["errors"] = tally.errors;
  if (tally.runs() > 0) out["failure_rate_at_most"] = json_number(tally.failure_rate_at_most());
}

Json json_of(const SweepHeader::Axis& axis, const std::vector<SweepTally>& tallies) {
  Json out = {{"key", axis.path}, {"values", Json::array()}};
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    Json value = {{"value", shown_value(axis.values[i])}};
    put_tally(value, tallies[i]);
    out["values"].push_back(value);
  }
  return out;
}

Json json_of(const SweepHeader& header, const SweepSummary::Worst& worst, const SweepCommand& command) {
  const SweepPoint& point = worst.point;
  return {{"index", point.index},
          {"seed", header.seed_of(point.index)},
          {"verdict", name_of(point.verdict)},
          {"excess", json_number(worst.excess)},
          {"reason", reason(header, point, worst)},
          {"faults", header.swarm.empty() ? Json(nullptr) : Json(point.faults_on)},
          {"again", command(point)}};
}

Json json_of(const SweepHeader& header, const SweepSummary::Find& found) {
  const SweepHeader::Axis& axis = header.grid[header.find->axis];
  Json out = {{header.find->smallest ? "smallest" : "largest", axis.path}, {"value", nullptr}};
  if (found.value) out["value"] = shown_value(axis.values[*found.value]);
  out["within_gate"] = found.within_gate;
  out["passing_beyond"] = found.beyond;
  return out;
}

/// A testcase of JUnit; with a problem, an error or a failure.
std::string testcase(const SweepHeader& header, const std::string& name, bool error, const std::string& problem,
                     const std::string& again) {
  using internal::xml_escape;
  std::string xml = fmt::format("    <testcase name=\"{}\" classname=\"{}\" file=\"{}\"", xml_escape(name),
                                xml_escape(header.name), xml_escape(header.file));
  if (problem.empty()) return xml + "/>\n";
  return xml + fmt::format(">\n      <{0} type=\"{0}\" message=\"{1}\">{1}\n{2}</{0}>\n    </testcase>\n",
                           error ? "error" : "failure", xml_escape(problem),
                           xml_escape(again.empty() ? "" : "reproduce: " + again + '\n'));
}

}  // namespace

std::string sweep_junit(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command) {
  std::string cases;
  std::int64_t tests = 0, failures = 0, errors = 0;
  const auto add = [&](const std::string& name, bool error, const std::string& problem, const std::string& again) {
    cases += testcase(header, name, error, problem, again);
    ++tests;
    if (!problem.empty()) ++(error ? errors : failures);
  };
  const SweepTally& all = summary.all;
  if (summary.find) {
    std::string found = find_text(header, *summary.find);
    found.pop_back();
    add(fmt::format("{} {}", header.find->smallest ? "smallest" : "largest", header.grid[header.find->axis].path), false,
        summary.find->within_gate ? "" : found, "");
  } else {
    add(fmt::format("{} of {} points pass", all.passed, all.runs()), false, "", "");
    for (const SweepSummary::Worst& one : summary.not_passed)
      add(values_of(header, one.point), one.point.verdict == SweepVerdict::error, reason(header, one.point, one),
          command(one.point));
    const std::int64_t others = all.failed + all.errors - std::ssize(summary.not_passed);
    if (others > 0) add("further points", all.errors > 0, fmt::format("{} more points do not pass", others), "");
  }
  for (std::size_t i = 0; i < header.sometimes.size() && summary.complete; ++i)
    add("sometimes: " + header.sometimes[i].name, false, summary.reached[i] > 0 ? "" : "no point reached this state", "");
  for (const std::string& one : unjudged(header, summary)) add(one, false, unjudged_text(one), "");
  const std::string totals = fmt::format(" tests=\"{}\" failures=\"{}\" errors=\"{}\"", tests, failures, errors);
  std::string xml = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites{0}>\n  <testsuite name=\"{1}\"{0}"
      " skipped=\"0\" file=\"{2}\">\n    <properties>\n",
      totals, internal::xml_escape(header.name), internal::xml_escape(header.file));
  for (const auto& [name, value] :
       {std::pair("scenario", header.scenario), std::pair("build", header.build),
        std::pair("points", fmt::format("{}", header.points())), std::pair("passed", fmt::format("{}", all.passed)),
        std::pair("failed", fmt::format("{}", all.failed)), std::pair("errors", fmt::format("{}", all.errors))})
    xml += fmt::format("      <property name=\"{}\" value=\"{}\"/>\n", name, internal::xml_escape(value));
  return xml + "    </properties>\n" + cases + "  </testsuite>\n</testsuites>\n";
}

std::string shown_value(const std::string& toml) {
  const bool plain = toml.size() >= 2 && toml.front() == '"' && toml.find_first_of("\"\\", 1) == toml.size() - 1;
  return plain ? toml.substr(1, toml.size() - 2) : toml;
}

std::string sweep_text(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command) {
  std::size_t width = 12;
  for (const SweepHeader::Axis& axis : header.grid) {
    width = std::max(width, axis.path.size());
    for (const std::string& value : axis.values) width = std::max(width, shown_value(value).size() + 2);
  }
  std::string out =
      fmt::format("{:<{}} {:>9} {:>9} {:>9}   failure rate at most (95 %)\n", "", width, "passed", "failed", "errors");
  out += fmt::format("{:<{}} {}\n", fmt::format("{} points", summary.all.runs()), width, tally_cells(summary.all));
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis) {
    out += header.grid[axis].path + '\n';
    for (std::size_t i = 0; i < summary.values[axis].size(); ++i)
      out += fmt::format("  {:<{}} {}\n", shown_value(header.grid[axis].values[i]), width - 2,
                         tally_cells(summary.values[axis][i]));
  }
  if (summary.stopped)
    out +=
        fmt::format("stopped after failure {}: {} of {} points\n", *header.stop_after, summary.all.runs(), header.points());
  if (!summary.worst.empty()) out += "worst points\n";
  for (const SweepSummary::Worst& worst : summary.worst) {
    const SweepPoint& point = worst.point;
    out += fmt::format("  {:<5} {}: {}\n        {}\n", name_of(point.verdict), values_of(header, point),
                       reason(header, point, worst), command(point));
  }
  if (summary.find) out += find_text(header, *summary.find);
  out += state_text(header, summary);
  for (const std::string& one : unjudged(header, summary)) out += fmt::format("error: {}\n", unjudged_text(one));
  return out;
}

std::string sweep_json(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command) {
  Json out = {{"sweep", header.name}, {"scenario", header.scenario}, {"build", header.build}};
  put_tally(out, summary.all);
  out["stopped"] = summary.stopped;
  out["grid"] = Json::array();
  for (std::size_t axis = 0; axis < header.grid.size(); ++axis)
    out["grid"].push_back(json_of(header.grid[axis], summary.values[axis]));
  out["worst"] = Json::array();
  for (const SweepSummary::Worst& worst : summary.worst) out["worst"].push_back(json_of(header, worst, command));
  out["find"] = summary.find ? json_of(header, *summary.find) : Json(nullptr);
  out["sometimes"] = Json::array();
  for (std::size_t i = 0; i < header.sometimes.size(); ++i) {
    out["sometimes"].push_back({{"name", header.sometimes[i].name},
                                {"reached", summary.reached[i]},
                                {"verdict", !summary.complete        ? "not judged"
                                            : summary.reached[i] > 0 ? "pass"
                                                                     : "fail"}});
  }
  out["unjudged"] = unjudged(header, summary);
  return json_text(out) + '\n';
}

}  // namespace evenstep
