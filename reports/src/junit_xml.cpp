#include <fmt/format.h>

#include <algorithm>

#include "evenstep/reports/limit_text.h"
#include "evenstep/reports/writers.h"
#include "src/text.h"

namespace evenstep {
namespace {

using internal::xml_escape;
using Verdict = ExpectationResult::Verdict;

std::string attribute(std::string_view name, std::string_view value) {
  return fmt::format(" {}=\"{}\"", name, xml_escape(value));
}

/// An expectation that does not hold is a failure, also where only the machine was too slow (type "degraded").
std::string problem(Verdict verdict, const std::string& message, const std::string& text) {
  const char* const element = verdict == Verdict::error ? "error" : "failure";
  const char* const type = verdict == Verdict::degraded ? "degraded" : element;
  return fmt::format("      <{0}{1}{2}>{3}</{0}>\n", element, attribute("type", type), attribute("message", message),
                     xml_escape(text));
}

std::string testcase(const RunRecord& run, const ExpectationResult& result, const std::string& reproduce) {
  const std::string name = fmt::format("{} {} {}", result.signal, result.metric, limit_text(result));
  std::string xml = fmt::format("    <testcase{}{}{}{}", attribute("name", name), attribute("classname", run.scenario),
                                attribute("file", result.file), attribute("line", fmt::format("{}", result.line)));
  if (result.verdict == Verdict::pass) return xml + "/>\n";
  if (result.verdict == Verdict::skipped)
    return xml + ">\n      <skipped" + attribute("message", result.detail) + "/>\n    </testcase>\n";
  const std::string message = failure_message(result);
  std::string text = fmt::format("{}:{}: {}\n", result.file, result.line, message);
  if (!result.because.empty()) text += "because: " + result.because + '\n';
  if (!reproduce.empty()) text += "reproduce: " + reproduce + '\n';
  return xml + ">\n" + problem(result.verdict, message, text) + "    </testcase>\n";
}

std::string failed_run(const RunRecord& run, const std::string& error, const std::string& reproduce) {
  std::string text = error + '\n';
  if (!reproduce.empty()) text += "reproduce: " + reproduce + '\n';
  return fmt::format("    <testcase{}{}{}>\n{}    </testcase>\n", attribute("name", "run"),
                     attribute("classname", run.scenario), attribute("file", run.file),
                     problem(Verdict::error, error, text));
}

}  // namespace

std::string failure_message(const ExpectationResult& result) {
  std::string message =
      fmt::format("{} {}: {}, limit {}", result.signal, result.metric, value_text(result), limit_text(result));
  if (result.expect_fail) message += " (was expected to fail)";
  if (!result.detail.empty()) message += ": " + result.detail;
  if (!result.where.empty()) message += ": " + result.where;
  return message;
}

std::string junit_xml(const RunRecord& run, const std::vector<ExpectationResult>& results, const std::string& error,
                      const std::string& reproduce) {
  const auto count = [&](Verdict verdict) {
    return static_cast<std::size_t>(
        std::count_if(results.begin(), results.end(), [&](const auto& r) { return r.verdict == verdict; }));
  };
  const std::size_t run_failed = error.empty() ? 0 : 1;
  const std::string totals = fmt::format(" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"{}\"",
                                         results.size() + run_failed, count(Verdict::fail) + count(Verdict::degraded),
                                         count(Verdict::error) + run_failed, count(Verdict::skipped));
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + totals + ">\n";
  xml += "  <testsuite" + attribute("name", run.scenario) + totals + attribute("file", run.file) + ">\n";
  xml += fmt::format(
      "    <properties>\n      <property name=\"seed\" value=\"{}\"/>\n      <property name=\"clock\"{}/>\n"
      "      <property name=\"trace_hash\" value=\"{:016x}\"/>\n    </properties>\n",
      run.seed, attribute("value", run.clock), run.trace_hash);
  if (run_failed) xml += failed_run(run, error, reproduce);
  for (const ExpectationResult& result : results) xml += testcase(run, result, reproduce);
  return xml + "  </testsuite>\n</testsuites>\n";
}

}  // namespace evenstep
