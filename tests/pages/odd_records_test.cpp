// Pages of records as a run that stopped, a hostile name or an odd number leaves them.
#include "catch.h"
#include "evenstep/pages/comparison_page.h"
#include "evenstep/pages/index_page.h"
#include "evenstep/pages/run_page.h"

namespace evenstep {
namespace {

using Catch::Contains;
using Verdict = ExpectationResult::Verdict;

ExpectationResult result(Verdict verdict) {
  ExpectationResult one;
  one.file = "x.toml";
  one.line = 2;
  one.signal = "left.force.direct";
  one.metric = "late";
  one.max = 1;
  one.value = verdict == Verdict::fail ? 2 : 1;
  one.verdict = verdict;
  return one;
}

std::string page_of(const std::vector<ExpectationResult>& results, const std::string& failure = "",
                    std::vector<SourceText> sources = {}) {
  RunRecord run;
  run.file = "x.toml";
  run.clock = "virtual";
  const Metrics metrics;
  return run_page({.run = run,
                   .metrics = metrics,
                   .results = results,
                   .verdict = "fail",
                   .failure = failure,
                   .remedy = failure.empty() ? "" : "smaller <steps>",
                   .sources = std::move(sources)});
}

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST_CASE("the first sentence of a run counts its expectations by verdict, and leaves out those for the other clock") {
  CHECK_THAT(
      page_of({result(Verdict::error), result(Verdict::fail), result(Verdict::fail), result(Verdict::degraded),
               result(Verdict::pass), result(Verdict::skipped)}),
      Contains("1 of 5 expectations could not be judged; 2 of 5 expectations failed; 1 of 5 expectations did not hold "
               "because the machine was too slow."));
  CHECK_THAT(page_of({result(Verdict::pass)}), Contains("The one expectation held."));
  CHECK_THAT(page_of({result(Verdict::pass), result(Verdict::pass), result(Verdict::skipped)}),
             Contains("All 2 expectations held.") && Contains("not judged under this clock"));
  for (const auto& results : {std::vector<ExpectationResult>{}, std::vector{result(Verdict::skipped)}})
    CHECK_THAT(page_of(results), Contains("Nothing was asserted, so this is no verdict"));
}

TEST_CASE("a run that stopped says why and what helps in place of a count, and has no charts of what it has not computed") {
  const std::string page = page_of({}, "the solver <diverged>");
  CHECK_THAT(page, Contains("Stopped: </strong>the solver &lt;diverged&gt;") && Contains("smaller &lt;steps&gt;"));
  CHECK_THAT(page, !Contains("Nothing was asserted") && !Contains("uPlot"));
}

TEST_CASE("a value that is missing, no number or infinite has a bar of numbers, and no mark where there is none") {
  ExpectationResult none = result(Verdict::error), nan = result(Verdict::fail), infinite = result(Verdict::fail);
  none.value.reset();
  nan.value = std::numeric_limits<double>::quiet_NaN();
  infinite.value = std::numeric_limits<double>::infinity();
  infinite.min = -1;
  const auto bar = [](const ExpectationResult& one) {
    const std::string page = page_of({one});
    const std::size_t from = page.find("</title>", page.find("<svg class=\"margin\""));  // the title is text
    return page.substr(from, page.find("</svg>", from) - from);
  };
  for (const ExpectationResult& one : {none, nan})
    CHECK_THAT(bar(one), !Contains("class=\"good\"") && !Contains("class=\"bad\""));
  CHECK_THAT(bar(infinite), Contains("class=\"bad\""));
  for (const ExpectationResult& one : {none, nan, infinite}) CHECK_THAT(bar(one), !Contains("nan") && !Contains("inf"));
  CHECK_THAT(page_of({none}), Contains("no sample was judged"));
}

TEST_CASE("a scenario's lines are those of its file, whatever ends them, and one that failed says why") {
  const std::string page = page_of({result(Verdict::fail)}, "", {{"x.toml", "first\r\n<second>\r\n\n\rfourth"}});
  CHECK(occurrences(page, "<li id=\"line-") == 4);
  CHECK(occurrences(page, "class=\"failed\"") == 1);
  CHECK_THAT(page, Contains(">first</li>") && Contains("-2\" class=\"failed\">&lt;second&gt;<span class=\"why\">"));
  CHECK_THAT(page_of({result(Verdict::fail)}, "", {{"other.toml", "first\nsecond"}}), !Contains("class=\"failed\""));
}

TEST_CASE("a page of many runs shows the latest of each scenario, and a name leads to no other place than its own") {
  std::vector<IndexedRun> runs{
      {"b", "javascript:alert(1)//é", "<one>", "one.toml", "2026-01-02", "0123456789abcdef", "pass", 0.5, "late"},
      {"a", "a/report.html", "<one>", "one.toml", "2026-01-01", "", "fail", -3, "late"},
      {"c", "c", "two", "two.toml", "", "", "error", std::nullopt, ""}};
  const std::string page = index_page("runs", runs, "evenstep index runs");
  CHECK_THAT(page, Contains("3 runs of 2 scenarios; the latest run of 1 of them passes") && Contains("verdict fail"));
  CHECK_THAT(page, Contains("href=\"./javascript%3Aalert%281%29//%C3%A9\"") && Contains("&lt;one&gt;"));
  CHECK_THAT(page, Contains("worst margin of 2 runs, from -300 % to 50 %") && Contains("worst margin of 1 runs, from none"));
  CHECK_THAT(page, Contains(">0123456789ab</code>") && Contains("no date"));
  CHECK(occurrences(page, "stroke=\"#d55e00\"") == 2);  // a cross for each run that did not pass

  runs.resize(1);
  CHECK_THAT(index_page("runs", runs, ""), Contains("<circle") && Contains("the latest run of 1 of them passes"));
  runs.assign(250, runs.front());
  const std::string long_trend = index_page("runs", runs, "");
  const std::size_t from = long_trend.find("points=\"") + 8;
  CHECK(occurrences(long_trend.substr(from, long_trend.find('"', from) - from), ",") == 100);
  CHECK(occurrences(long_trend, "<tr>") == 250 + 1 + 2);  // all runs are in the list
}

TEST_CASE("a page of a comparison names what broke its conditions, and leaves out what a browser cannot show") {
  ComparisonRecord record;
  record.a.given = "a";
  record.b.given = "<b>";
  record.runs.push_back({"one", "x", ComparedRun::In::both, {"another seed"}, 7, 5, "0123"});
  record.runs.push_back({"two", "y", ComparedRun::In::only_a, {}, 0, 0, ""});
  record.conditions.push_back({"late 5 %", 1, 1});
  ComparedFigure figure;
  figure.signal = "left.force.direct";
  figure.metric = "late";
  figure.unit = "count";
  figure.a = 1;
  figure.b = 2;
  figure.change = ComparedFigure::Change::worse;
  figure.breaks = {0};
  record.figures.push_back(figure);
  figure.breaks.clear();
  record.figures.resize(6001, figure);
  const std::string page = comparison_page(record, "evenstep compare a b");
  CHECK_THAT(page, Contains("a → &lt;b&gt;") && Contains("verdict fail") && Contains("; late 5 %"));
  CHECK_THAT(page, Contains("another seed") && Contains("only A") && Contains("bit-equal, trace 0123"));
  CHECK_THAT(page, Contains("1001 more are left out"));
}

}  // namespace
}  // namespace evenstep
