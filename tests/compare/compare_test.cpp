#include "evenstep/campaigns/compare.h"

#include "catch.h"
#include "evenstep/campaigns/threshold.h"

using namespace evenstep;
using Catch::Contains;
using Change = ComparedFigure::Change;
using Verdict = ExpectationResult::Verdict;

namespace {

const std::string kPaperBuffers = "left.buffers.paper";

RunSummary run_named(const std::string& name) {
  RunSummary run;
  run.name = name;
  run.file = "s/" + name + ".toml";
  run.scenario = "Scenario " + name;
  run.evenstep = "0.2.0";
  run.clock = "virtual";
  run.verdict = "pass";
  run.trace_hash = "0123456789abcdef";
  run.digest = "0000000000000001";
  run.date = "2026-11-23T11:05:13Z";
  run.commit = std::string(40, 'a');
  run.metrics = {{kPaperBuffers, {{"latency", 0.010}, {"underruns", 0.0}, {"lead", 0.001}}},
                 {"left.force.paper", {{"gain", std::nullopt}, {"judged", 100.0}}},
                 {"solver.paper", {{"solver_seconds", 0.5}, {"k_max", 200.0}}}};
  run.strategies["paper"] = {"cpu-double", "", "none", {}};
  ExpectationResult expectation;
  expectation.signal = kPaperBuffers;
  expectation.metric = "latency";
  expectation.unit = "ms";
  expectation.value = 10;
  expectation.max = 20;
  run.expectations = {expectation};
  return run;
}

ComparisonRecord compared(const std::vector<RunSummary>& a, const std::vector<RunSummary>& b,
                          const std::vector<std::string>& conditions = {"verdict"}, bool allow_missing = false) {
  std::vector<Threshold> thresholds;
  for (const std::string& text : conditions) thresholds.push_back(parse_threshold(text).value());
  return compare({"a", a}, {"b", b}, thresholds, allow_missing);
}
ComparisonRecord compared(const RunSummary& a, const RunSummary& b,
                          const std::vector<std::string>& conditions = {"verdict"}) {
  return compared(std::vector{a}, std::vector{b}, conditions);
}

const ComparedFigure* figure(const ComparisonRecord& record, const std::string& metric) {
  for (const ComparedFigure& one : record.figures) {
    if (one.metric == metric) return &one;
  }
  return nullptr;
}
std::string notes(const ComparisonRecord& record) {
  std::string all;
  for (const ComparedRun& run : record.runs) {
    for (const std::string& note : run.notes) all += note + '\n';
  }
  return all;
}

}  // namespace

TEST_CASE("two runs that are the same to the last bit are called bit-equal, whatever the solver's time was") {
  RunSummary b = run_named("x");
  b.metrics["solver.paper"]["solver_seconds"] = 0.7;
  const ComparisonRecord record = compared(run_named("x"), b);
  CHECK(record.holds());
  CHECK(record.runs.at(0).trace_hash == "0123456789abcdef");
  CHECK(shown_figures(record, false).empty());
  CHECK(record.runs[0].equal + 1 == record.runs[0].figures);
  b.trace_hash = "f123456789abcdef";
  CHECK(compared(run_named("x"), b).runs.at(0).trace_hash.empty());
}

TEST_CASE("which way a metric got worse is known for each, and the largest change stands first") {
  RunSummary b = run_named("x");
  b.metrics[kPaperBuffers]["latency"] = 0.011;
  b.metrics[kPaperBuffers]["lead"] = 0.0005;
  b.metrics["solver.paper"]["k_max"] = 100;
  b.metrics["left.force.paper"]["judged"] = 99;
  const ComparisonRecord record = compared(run_named("x"), b);
  REQUIRE(shown_figures(record, false).size() == 4);
  CHECK(record.figures[0].metric == "k_max");    // -50 %
  CHECK(record.figures[1].metric == "latency");  // +10 %
  CHECK(figure(record, "latency")->change == Change::worse);
  CHECK(figure(record, "k_max")->change == Change::worse);
  CHECK(figure(record, "lead")->change == Change::better);
  CHECK(figure(record, "judged")->change == Change::other);
  CHECK(record.holds());  // there was no condition
}

TEST_CASE("a threshold counts what it judged and what it broke, and broken ones stand first") {
  RunSummary b = run_named("x");
  b.metrics[kPaperBuffers]["latency"] = 0.0106;
  b.metrics["solver.paper"]["k_max"] = 100;
  const ComparisonRecord record = compared(run_named("x"), b, {"latency > +5 %", "latency > +1 ms", "lead > +0 s"});
  CHECK_FALSE(record.holds());
  CHECK(record.conditions[0].judged == 1);
  CHECK(record.conditions[0].broken == 1);
  CHECK(record.conditions[1].holds());
  CHECK(record.conditions[2].holds());
  CHECK(record.figures[0].metric == "latency");
  CHECK(record.figures[0].breaks == std::vector<std::size_t>{0});
}

TEST_CASE("numbers below 1e-12 of the largest of their signal are rounding: no better, no worse, and no threshold breaks") {
  RunSummary a = run_named("x");
  a.metrics["left.force.paper"] = {{"error_max", 0.4}, {"deviation_max", 1.6e-14}, {"jump_max", 3e-13}};
  RunSummary b = a;
  b.metrics["left.force.paper"]["deviation_max"] = 2.2e-14;
  const ComparisonRecord record = compared(a, b, {"deviation_max > +5 %", "worse > +1 %"});
  CHECK(record.holds());
  CHECK(figure(record, "deviation_max")->rounding);
  CHECK(figure(record, "deviation_max")->change == Change::other);
  CHECK(shown_figures(record, false).empty());
  b.metrics["left.force.paper"]["jump_max"] = 5e-13;  // above 1e-12 of 0.4 N
  CHECK_FALSE(compared(a, b, {"worse > +1 %"}).holds());
  // A small value alone is no sign of rounding: here the signal has nothing larger.
  a.metrics["left.force.paper"] = {{"deviation_max", 1.6e-14}};
  b.metrics["left.force.paper"] = {{"deviation_max", 2.2e-14}};
  CHECK_FALSE(compared(a, b, {"worse > +1 %"}).holds());
}

TEST_CASE("a threshold that could judge no figure does not hold") {
  const ComparisonRecord record = compared(run_named("x"), run_named("x"), {"phase_delay > +5 %"});
  CHECK(record.conditions[0].judged == 0);
  CHECK_FALSE(record.holds());
  CHECK_THAT(condition_text(record.conditions[0]), Contains("there is no figure that it could judge"));
}

TEST_CASE("a number that is gone breaks every threshold on it, and so does one that was never there") {
  RunSummary a = run_named("x"), b = a;
  b.metrics[kPaperBuffers]["latency"] = std::nullopt;
  CHECK_FALSE(compared(a, b, {"latency > +5 %"}).holds());
  CHECK_FALSE(compared(a, b, {"worse > +5 %"}).holds());
  CHECK_FALSE(compared(b, a, {"latency > +5 %"}).holds());
  CHECK_FALSE(compared(b, b, {"latency > +5 %"}).holds());
  CHECK(figure(compared(a, b), "latency")->change == Change::incomparable);
  CHECK_THAT(notes(compared(b, b)), Contains("2 figures have no number on either side"));
  b.metrics[kPaperBuffers].erase("latency");
  CHECK_FALSE(compared(a, b, {"latency > +5 %"}).holds());
  CHECK_FALSE(compared(a, b, {"worse > +5 %"}).holds());
  CHECK_FALSE(compared(a, b, {"missing"}).holds());
  CHECK(compared(b, a, {"missing"}).holds());
  CHECK_FALSE(compared(b, a, {"latency > +5 %"}).holds());  // the condition judged nothing
}

TEST_CASE("a verdict that gets worse breaks the default condition, and one that gets better does not") {
  RunSummary a = run_named("x"), b = a;
  b.verdict = "fail";
  b.expectations[0].verdict = Verdict::fail;
  const ComparisonRecord worse = compared(a, b);
  CHECK_FALSE(worse.holds());
  CHECK(worse.conditions[0].broken == 2);
  CHECK(worse.figures[0].metric == "verdict");
  CHECK(compared(b, a).holds());
  b = a;
  b.expectations.clear();
  CHECK_FALSE(compared(a, b).holds());  // the expectation is gone, so nobody knows its verdict
  CHECK(compared(b, a).holds());
}

TEST_CASE("an expectation keeps its name when its limit is changed, and that is said") {
  RunSummary a = run_named("x"), b = a;
  b.expectations[0].max = 200;
  const ComparisonRecord record = compared(a, b, {"verdict", "margin < -10 %"});
  CHECK_THAT(notes(record), Contains("another limit on left.buffers.paper: A latency <= 20 ms, B latency <= 200 ms"));
  CHECK(record.holds());
  CHECK_FALSE(compared(b, a, {"margin < -10 %"}).holds());
}

namespace {

/// Two devices, and an expectation on the worst of both.
RunSummary with_pattern(double left, double right, double max) {
  RunSummary run = run_named("x");
  run.metrics["left.force.paper"] = {{"jump_max", left}};
  run.metrics["right.force.paper"] = {{"jump_max", right}};
  ExpectationResult& expectation = run.expectations[0];
  expectation.signal = left > right ? "left.force.paper" : "right.force.paper";
  expectation.pattern = "*.force.paper";
  expectation.metric = "jump_max";
  expectation.unit = "N";
  expectation.value = std::max(left, right);
  expectation.max = max;
  expectation.file = "s/x.toml";
  expectation.line = 12;
  expectation.verdict = std::max(left, right) <= max ? Verdict::pass : Verdict::fail;
  return run;
}

}  // namespace

TEST_CASE("expectations are paired as they are written, whichever signal is the worst of those that a star matches") {
  const RunSummary a = with_pattern(3, 1, 5), b = with_pattern(1, 2, 5);
  const ComparisonRecord better = compared(a, b, {"verdict", "missing", "margin < -1 %"});
  CHECK(better.holds());
  REQUIRE(figure(better, "margin") != nullptr);
  CHECK(figure(better, "margin")->signal == "*.force.paper");
  CHECK(figure(better, "margin")->change == Change::better);
  CHECK(figure(better, "verdict") == nullptr);
  CHECK_FALSE(compared(b, a, {"margin < -1 %"}).holds());
  CHECK_FALSE(compared(a, with_pattern(1, 6, 5)).holds());
  CHECK_THAT(notes(compared(a, with_pattern(1, 2, 4))), Contains("another limit on *.force.paper: A jump_max <= 5 N"));
}

TEST_CASE("a condition on a signal judges the margin of a pattern that may be about it") {
  const RunSummary a = with_pattern(1, 2, 5), b = with_pattern(3, 1, 5);
  for (const char* condition :
       {"left.force.paper margin < -1 %", "paper margin < -1 %", "* margin < -1 %", "*.force.* margin < -1 %"}) {
    INFO(condition);
    CHECK(compared(a, b, {condition}).conditions.at(0).broken == 1);
  }
  for (const char* condition : {"left.buffers.paper margin < -1 %", "direct margin < -1 %", "run margin < -1 %"}) {
    INFO(condition);
    CHECK(compared(a, b, {condition}).conditions.at(0).judged == 0);
  }
}

TEST_CASE("an older summary without patterns is paired by the place of the expectation, and by the signal if that moved") {
  RunSummary a = with_pattern(3, 1, 5), b = with_pattern(1, 2, 5);
  a.expectations[0].pattern.clear();
  CHECK(compared(a, b).holds());
  CHECK(compared(b, a).holds());
  b.expectations[0].line = 13;
  CHECK_FALSE(compared(a, b).holds());
  b = with_pattern(2, 1, 5);
  b.expectations[0].pattern.clear();
  CHECK(compared(a, b, {"verdict", "missing"}).holds());
}

TEST_CASE("runs are compared by the place in their folder, then by their scenario's file") {
  RunSummary x = run_named("x"), y = run_named("y"), moved = run_named("y");
  moved.name = "elsewhere/y";
  const ComparisonRecord record = compared({x, y}, {x, moved});
  REQUIRE(record.runs.size() == 2);
  CHECK(record.runs[1].name == "elsewhere/y");
  CHECK(record.runs[1].in == ComparedRun::In::both);
  RunSummary renamed = run_named("z");
  CHECK(compared(x, renamed).runs.size() == 1);  // two single runs are always a pair
  CHECK_THAT(notes(compared(x, renamed)), Contains("another scenario: A is 'Scenario x', B is 'Scenario z'"));
}

TEST_CASE("a run that is gone breaks every condition, unless that is allowed, and a new one breaks none") {
  const RunSummary x = run_named("x"), y = run_named("y");
  const ComparisonRecord gone = compared({x, y}, {x}, {"latency > +5 %", "trace"});
  CHECK(gone.conditions[0].broken == 1);
  CHECK(gone.conditions[1].broken == 1);
  CHECK_THAT(notes(gone), Contains("is only in A"));
  CHECK(compared({x, y}, {x}, {"latency > +5 %"}, true).holds());
  const ComparisonRecord fresh = compared({x}, {x, y}, {"latency > +5 %", "missing"});
  CHECK(fresh.holds());
  CHECK_THAT(notes(fresh), Contains("is only in B"));
}

TEST_CASE("what makes two runs not the same thing measured twice is said") {
  const RunSummary a = run_named("x");
  RunSummary b = a;
  b.seed = 7;
  b.clock = "wall";
  b.real_time_granted = false;
  b.left_out = {"local stiffness"};
  b.failure = "the solver diverged";
  b.strategies["paper"] = {"opencl-float", "pocl", "verlet", {"energy"}};
  b.strategies["direct"] = {};
  for (const char* note : {"another seed: A 0, B 7", "another clock", "real-time priority was granted in A only",
                           "features that were left out: A 0, B 1", "B stopped: the solver diverged",
                           "another solver: A 'cpu-double', B 'opencl-float'", "another solver device", "another method",
                           "what its solver lacks: A '', B 'energy'", "strategy 'direct' is only in B"})
    CHECK_THAT(notes(compared(a, b)), Contains(note));
  CHECK_THAT(notes(compared(b, a)), Contains("strategy 'direct' is only in A"));
}

TEST_CASE("of scenarios that differ in many lines six are shown, and the others are counted") {
  RunSummary a = run_named("x"), b = a;
  b.digest = "0000000000000002";
  a.resolved = b.resolved = {"[timing]"};
  for (int i = 0; i < 5; ++i) {
    a.resolved.push_back("key" + std::to_string(i) + " = 1");
    b.resolved.push_back("key" + std::to_string(i) + " = 2");
  }
  const std::string text = notes(compared(a, b));
  CHECK_THAT(text, Contains("the scenarios differ: A has timing.key4 = 1") && Contains("B has timing.key0 = 2") &&
                       !Contains("B has timing.key1 = 2") &&
                       Contains("the scenarios differ in 4 more lines of resolved.toml"));
}

TEST_CASE("scenarios that differ are compared line by line, as far as their runs say what they were") {
  RunSummary a = run_named("x"), b = a;
  b.digest = "0000000000000002";
  CHECK_THAT(notes(compared(a, b)), Contains("the scenarios differ; a resolved.toml"));
  a.resolved = {"name = 'x'", "[timing]", "steps = 15", "[[device]]", "rate = '1 kHz'", "[[expect]]", "max = '1 ms'"};
  b.resolved = {"name = 'y'", "[timing]", "steps = 14", "[[device]]", "rate = '1 kHz'", "[[expect]]", "max = '2 ms'"};
  CHECK(notes(compared(a, b)) ==
        "the scenarios differ: A has timing.steps = 15\nthe scenarios differ: B has timing.steps = "
        "14\n1 figures have no number on either side, so nobody can compare them\n");
  b.digest.clear();
  CHECK_THAT(notes(compared(a, b)), Contains("the summary of B (evenstep 0.2.0) has no scenario_digest"));
}
