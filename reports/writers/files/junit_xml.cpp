#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "evenstep/reports/limit_text.h"
#include "evenstep/reports/writers.h"
#include "writers/texts/text.h"

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

std::string testcase(const JunitSuite& suite, const ExpectationResult& result) {
  const std::string name = fmt::format("{} {} {}", result.pattern, result.metric, limit_text(result));
  std::string xml = fmt::format("    <testcase{}{}{}{}", attribute("name", name), attribute("classname", suite.scenario),
                                attribute("file", result.file), attribute("line", fmt::format("{}", result.line)));
  if (result.verdict == Verdict::pass) return xml + "/>\n";
  if (result.verdict == Verdict::skipped)
    return xml + ">\n      <skipped" + attribute("message", result.detail) + "/>\n    </testcase>\n";
  const std::string message = failure_message(result);
  std::string text = fmt::format("{}:{}: {}\n", result.file, result.line, message);
  if (!result.because.empty()) text += "because: " + result.because + '\n';
  if (!suite.reproduce.empty()) text += "reproduce: " + suite.reproduce + '\n';
  return xml + ">\n" + problem(result.verdict, message, text) + "    </testcase>\n";
}

std::string whole_run(const JunitSuite& suite) {
  using Whole = JunitSuite::Whole;
  if (suite.whole == Whole::silent) return {};
  const std::string xml = fmt::format("    <testcase{}{}{}", attribute("name", "run"),
                                      attribute("classname", suite.scenario), attribute("file", suite.file));
  if (suite.whole == Whole::passed) return xml + "/>\n";
  std::string text = suite.why + '\n';
  if (!suite.reproduce.empty()) text += "reproduce: " + suite.reproduce + '\n';
  const Verdict verdict = suite.whole == Whole::broken ? Verdict::error : Verdict::fail;
  return xml + ">\n" + problem(verdict, suite.why, text) + "    </testcase>\n";
}

struct Totals {
  std::ptrdiff_t tests = 0, failures = 0, errors = 0, skipped = 0;
  void add(const Totals& other) {
    tests += other.tests;
    failures += other.failures;
    errors += other.errors;
    skipped += other.skipped;
  }
  std::string attributes() const {
    return fmt::format(" tests=\"{}\" failures=\"{}\" errors=\"{}\"", tests, failures, errors);
  }
};

Totals totals_of(const JunitSuite& suite) {
  const auto count = [&](Verdict verdict) {
    return std::count_if(suite.results.begin(), suite.results.end(), [&](const auto& r) { return r.verdict == verdict; });
  };
  using Whole = JunitSuite::Whole;
  return {std::ssize(suite.results) + (suite.whole == Whole::silent ? 0 : 1),
          count(Verdict::fail) + count(Verdict::degraded) + (suite.whole == Whole::failed ? 1 : 0),
          count(Verdict::error) + (suite.whole == Whole::broken ? 1 : 0), count(Verdict::skipped)};
}

std::string testsuite(const JunitSuite& suite) {
  const Totals totals = totals_of(suite);
  std::string xml = fmt::format("  <testsuite{}{} skipped=\"{}\"{}>\n", attribute("name", suite.scenario),
                                totals.attributes(), totals.skipped, attribute("file", suite.file));
  if (!suite.clock.empty())
    xml += fmt::format(
        "    <properties>\n      <property name=\"seed\" value=\"{}\"/>\n      <property name=\"clock\"{}/>\n"
        "      <property name=\"trace_hash\" value=\"{:016x}\"/>\n    </properties>\n",
        suite.seed, attribute("value", suite.clock), suite.trace_hash);
  xml += whole_run(suite);
  for (const ExpectationResult& result : suite.results) xml += testcase(suite, result);
  return xml + "  </testsuite>\n";
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

std::string junit_xml(std::span<const JunitSuite> suites) {
  Totals totals;
  for (const JunitSuite& suite : suites) totals.add(totals_of(suite));
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + totals.attributes() + ">\n";
  for (const JunitSuite& suite : suites) xml += testsuite(suite);
  return xml + "</testsuites>\n";
}

}  // namespace evenstep
