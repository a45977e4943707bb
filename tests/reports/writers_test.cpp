#include "evenstep/reports/writers.h"

#include <array>
#include <cmath>
#include <sstream>

#include "catch.h"
#include "samples.h"
#include "writers/texts/text.h"

using namespace evenstep;
using Catch::Contains;
using synthetic::written;
using Verdict = ExpectationResult::Verdict;

namespace {

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) result.push_back(line);
  return result;
}

}  // namespace

TEST_CASE("the worst verdict wins, in any order: error, fail, degraded, pass, skipped, nothing judged is skipped") {
  const auto of = [](Verdict v) {
    ExpectationResult r;
    r.verdict = v;
    return r;
  };
  CHECK(worst({}) == Verdict::skipped);
  const std::vector<Verdict> all{Verdict::skipped, Verdict::pass, Verdict::degraded, Verdict::fail, Verdict::error};
  for (const Verdict a : all) {
    for (const Verdict b : all) CHECK(worst({of(a), of(b)}) == std::max(a, b));
  }
}

TEST_CASE("summary.json opens as the design says") {
  RunRecord run;
  run.scenario = "s";
  run.clock = "virtual";
  run.trace_hash = 0x1234;
  run.digest = 0xff;
  run.origin.date = "2026-11-23T11:05:13Z";
  ExpectationResult result = synthetic::nasty_results()[0];
  result.file = "x.toml";
  const std::string json = summary_json(run, {{"run", {{"a", 1.5}, {"b", NAN}}}}, {result}, "0.1.0", "pass");
  CHECK(json ==
        "{\"format\":1,\"evenstep\":\"0.1.0\",\"scenario\":\"s\",\"file\":\"\",\"scenario_digest\":\"00000000000000ff\","
        "\"date\":\"2026-11-23T11:05:13Z\",\"commit\":null,\"seed\":1,\"clock\":\"virtual\",\"real_time_"
        "granted\":"
        "true,\"verdict\":\"pass\","
        "\"trace_hash\":\"0000000000001234\",\"expectations\":[\n{\"line\":12,\"signal\":\"left.interaction.direct\","
        "\"metric\":\"velocity_jump\","
        "\"value\":4.995,\"unit\":\"step\",\"min\":4,\"max\":null,\"verdict\":\"pass\",\"file\":\"x.toml\",\"expect_fail\":"
        "false,\"because\":\"\","
        "\"detail\":\"\",\"where\":\"\",\"first\":null,\"worst\":null,\"pattern\":\"left.interaction.direct\"}],\"metrics\":"
        "{\"run\":{\"a\":1.5,\"b\":null}},"
        "\"saturated\":{},\"latency\":{},\"strategies\":{},\"growth\":{},\"bins\":{},\"left_"
        "out\":[],\"failure\":\"\"}\n");
}

TEST_CASE("the same record gives the same bytes") {
  const RunRecord run = synthetic::nasty_run();
  CHECK(summary_json(run, measure(run), {}, "1", "pass") == summary_json(run, measure(run), {}, "1", "pass"));
  CHECK(written(series_csv, run) == written(series_csv, run));
}

TEST_CASE("JUnit tells failures from errors, with file and line, and how to run it again") {
  const std::string xml = junit_xml(std::array{synthetic::nasty_suite()});
  CHECK(synthetic::occurrences(xml, "<testcase ") == 4);
  CHECK(synthetic::occurrences(xml, "<failure ") == 1);
  CHECK(synthetic::occurrences(xml, "<error ") == 1);
  CHECK(synthetic::occurrences(xml, " tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"0\"") == 1);
  CHECK_THAT(xml, Contains("file=\"scenarios/a&amp;b.toml\" line=\"20\"") && Contains("reproduce: evenstep run x"));
  CHECK_THAT(xml, Contains("left.force.µ schedule_latency: 13 ms, limit &lt;= 12.842 ms"));
  for (const char c : xml) CHECK((static_cast<unsigned char>(c) >= 0x20 || c == '\n'));
}

TEST_CASE("JUnit: a run that failed is an error of its own, also without expectations") {
  using Whole = JunitSuite::Whole;
  const auto xml_of = [](Whole whole) {
    JunitSuite suite = synthetic::nasty_suite();
    suite.results.clear();
    suite.whole = whole;
    suite.why = "the solver gave a NaN";
    return junit_xml(std::array{suite});
  };
  CHECK_THAT(xml_of(Whole::broken), Contains(" tests=\"1\" failures=\"0\" errors=\"1\"") && Contains("name=\"run\"") &&
                                        Contains("<error type=\"error\" message=\"the solver gave a NaN\""));
  CHECK_THAT(xml_of(Whole::failed), Contains(" tests=\"1\" failures=\"1\" errors=\"0\"") && Contains("<failure "));
  CHECK_THAT(xml_of(Whole::passed), Contains(" tests=\"1\" failures=\"0\" errors=\"0\"") && !Contains("NaN"));
  CHECK_THAT(xml_of(Whole::silent), Contains(" tests=\"0\" failures=\"0\" errors=\"0\""));
}

TEST_CASE("JUnit: the suites of one call stand in one document, and its totals are their sums") {
  JunitSuite broken;
  broken.scenario = "b";
  broken.whole = JunitSuite::Whole::broken;
  const std::string xml = junit_xml(std::array{synthetic::nasty_suite(), broken, synthetic::nasty_suite()});
  CHECK_THAT(xml, Contains("<testsuites tests=\"9\" failures=\"2\" errors=\"3\">"));
  CHECK(synthetic::occurrences(xml, "<testsuite name=") == 3);
  CHECK_THAT(junit_xml({}), Contains("<testsuites tests=\"0\" failures=\"0\" errors=\"0\">\n</testsuites>"));
}

TEST_CASE("JUnit and the table say what is skipped, what is degraded, and where a limit is broken") {
  std::vector<ExpectationResult> results = synthetic::nasty_results();
  results[0].verdict = Verdict::skipped;
  results[0].detail = "for the wall clock only";
  results[1].verdict = Verdict::degraded;
  results[1].where = "late first at step 960, 2.000 s, by 6.66 ms; latency 26.704 ms would do";
  JunitSuite suite = synthetic::nasty_suite();
  suite.results = results;
  const std::string xml = junit_xml(std::array{suite});
  CHECK_THAT(xml, Contains(" tests=\"4\" failures=\"1\" errors=\"1\" skipped=\"1\"") &&
                      Contains("<skipped message=\"for the wall clock only\"/>") && Contains("<failure type=\"degraded\"") &&
                      Contains("limit &lt;= 12.842 ms: late first at step 960, 2.000 s, by 6.66 ms; latency 26.704 ms"));
  const std::string table = verdict_table(results, false);
  CHECK_THAT(table, Contains("not judged") && Contains("DEGRADED") && Contains("\n    late first at step 960, 2.000 s"));
  CHECK(table.find("for the wall clock only") == std::string::npos);
}

TEST_CASE("the table of strategies has the largest values of the devices, and the sums of what they counted") {
  RunRecord run;
  run.strategies.resize(2);
  run.strategies[0].name = "direct";
  run.strategies[1].name = "paper";
  for (StrategyRecord& strategy : run.strategies) {
    strategy.devices.resize(2);
    strategy.devices[0].name = "left";
    strategy.devices[1].name = "right";
  }
  Metrics metrics;
  metrics["left.buffers.paper"] = {{"latency", 0.015}};
  metrics["right.buffers.paper"] = {{"latency", 0.0125}};
  metrics["left.interaction.paper"] = {{"velocity_jump", 1e-6}, {"underruns", 1}, {"judged", 100}, {"saturated", 5}};
  metrics["right.interaction.paper"] = {{"velocity_jump", 2.5e-6}, {"underruns", 2}, {"judged", 100}};
  metrics["left.force.paper"] = {{"jump_max", 0.25}, {"underruns", 7}, {"saturated", 30}};
  metrics["right.force.paper"] = {{"jump_max", 0.125}};
  metrics["left.force.direct"] = {{"jump_max", std::nan("")}};
  metrics["right.buffers.direct"] = {{"latency", 0}, {"played_age", 0.0043}};
  CHECK(strategy_table(run, {}).empty());  // nothing was measured
  CHECK(
      lines(strategy_table(run, metrics)) ==
      std::vector<std::string>{"strategy   latency  jump of hand  jump of force  late forces  missing samples  saturated",
                               "direct    ~4.30 ms             -              -            0                0          0",
                               "paper     15.00 ms       2.50 um      250.00 mN     7 of 200         3 of 200         35"});
}

TEST_CASE("the verdict table has one aligned row per expectation and says what failed") {
  const std::vector<std::string> rows = lines(verdict_table(synthetic::nasty_results(), false));
  REQUIRE(rows.size() == 1 + 4 + 2);  // a reason under the failure, a detail under the error
  const auto column_of = [&](const std::string& row, const std::string& word) {
    return internal::display_width(row.substr(0, row.find(word)));
  };
  const std::size_t limit = column_of(rows[0], "limit"), where = column_of(rows[0], "where");
  CHECK(column_of(rows[1], ">= 4 step") == limit);
  CHECK(column_of(rows[2], "<= 12.842 ms") == limit);  // µ before it is two bytes and one column
  CHECK(column_of(rows[4], "= 1 mm") == limit);
  CHECK(column_of(rows[6], "0 .. 1") == limit);
  for (const std::size_t row : {1, 2, 4, 6}) CHECK(column_of(rows[row], "scenarios/") == where);
  CHECK_THAT(rows[1], Contains("0.995") && Contains("pass"));   // 4.995 - 4
  CHECK_THAT(rows[2], Contains("-0.158") && Contains("FAIL"));  // 12.842 - 13
  CHECK_THAT(rows[3], Contains("because:") && Contains("newline?100 %"));
  CHECK_THAT(rows[4], Contains("no sample") && Contains("ERROR"));
  CHECK_THAT(rows[5], Contains("no sample was judged"));
  CHECK_THAT(rows[6], Contains("pass (fails as expected)"));
}

TEST_CASE("colours only where asked, and never from the scenario's text") {
  CHECK(verdict_table(synthetic::nasty_results(), false).find('\x1b') == std::string::npos);
  CHECK(synthetic::occurrences(verdict_table(synthetic::nasty_results(), true), "\x1b[") == 2 * 4);
}

TEST_CASE("series.csv quotes a name with a comma and keeps its columns") {
  RunRecord run = synthetic::reference_run({300'000'000});
  run.strategies.resize(1);
  run.strategies[0].devices[0].name = "left, \"upper\"";
  const std::vector<std::string> rows = lines(written(series_csv, run));
  CHECK_THAT(rows[0], Catch::StartsWith("t[s],strategy,device,kind,"));
  CHECK_THAT(rows[1], Contains(",\"left, \"\"upper\"\"\",step,"));
  const std::size_t columns = synthetic::occurrences(rows[0], ",");
  for (std::size_t i = 1; i < rows.size(); ++i)
    CHECK(synthetic::occurrences(rows[i], ",") == columns + 1);  // one comma is quoted
}

TEST_CASE("series.csv names how a step read, shows variable steps, and holds bins alone where no rows are kept") {
  RunRecord run = synthetic::reference_run();
  run.strategies.resize(1);
  StrategyRecord& only = run.strategies[0];
  only.devices[0].steps[0].read = StepRead::gated;
  only.devices[0].steps[1].read = StepRead::predicted;
  only.steps[1].simulated = SimTime{62'500'000};
  std::vector<std::string> rows = lines(written(series_csv, run));
  CHECK_THAT(rows[1], Contains(",gated,"));
  CHECK_THAT(rows[2], Contains(",predicted,") && !Contains(",step,1,0.0625,"));
  only.variable_step = true;
  CHECK_THAT(lines(written(series_csv, run))[2], Contains(",step,1,0.0625,"));
  only.variable_step = false;
  run.keep_rows = false;
  const std::vector<std::string> bins_only = lines(written(series_csv, run));
  REQUIRE(bins_only.size() == 1 + 52 + 52);  // 52 segments are judged
  CHECK(bins_only[0] == rows[0]);
  CHECK(std::vector(bins_only.begin() + 1, bins_only.end()) == std::vector(rows.end() - 104, rows.end()));
}

TEST_CASE("underruns.csv: the header always, then every row") {
  RunRecord run;
  const std::string header = "strategy,device,side,step,lateness_ns,policy\n";
  CHECK(written(underruns_csv, run) == header);
  run = synthetic::reference_run({300'000'000});
  run.strategies[1].devices[0].name = "a,b";
  run.strategies[1].underruns = {{0, 0, UnderrunRow::Side::interaction, {12}, "clamp"},
                                 {9'000'000'000, 0, UnderrunRow::Side::force, {INT64_MAX}, "extrapolate"}};
  CHECK(written(underruns_csv, run) == header +
                                           "direct,\"a,b\",interaction,0,12,clamp\n"
                                           "direct,\"a,b\",force,9000000000,9223372036854775807,extrapolate\n");
  run.strategies[0].underruns.assign(100'000, {1, 0, UnderrunRow::Side::force, {1}, "hold"});
  CHECK(lines(written(underruns_csv, run)).size() == 1 + 100'000 + 2);
}
