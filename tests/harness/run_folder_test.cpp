// The run folder is written completely or not at all.

#include "evenstep/harness/run_folder.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

#include "evenstep/harness/recorded_timing.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/recordings/timing_csv.h"
#include "scenarios.h"
#include "temporary_folder.h"

using namespace evenstep;
using namespace evenstep::test;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename().string());
  return names;
}

std::string content_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// A process that writes the folder so many times, and exits with 0 if it could each time.
pid_t writer_of(const std::string& folder, int times) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  for (int i = 0; i < times; ++i) {
    const std::string text = fmt::format("{} {}", ::getpid(), i);
    const std::string error = write_folder(folder, {{kSummaryFile, text}, {"second", text}});
    if (error.empty()) continue;
    std::fprintf(stderr, "%s\n", error.c_str());
    ::_exit(1);
  }
  ::_exit(0);
}

int status_of(pid_t child) {
  int status = -1;
  ::waitpid(child, &status, 0);
  return status;
}

}  // namespace

TEST_CASE("a run folder holds every file, and nothing is left beside it") {
  const TemporaryFolder temporary;
  const Scenario scenario = read("paper/figure-1-spring.toml", {"run.duration=\"0.6 s\""});
  const RunOutcome outcome = run_scenario(scenario, {});
  const std::string folder = temporary / "run";
  for (int again = 0; again < 2; ++again) {  // the second run replaces the folder of the first
    CHECK(run_folder_objection(folder) == "");
    CHECK(write_run_folder(folder, scenario, outcome, "evenstep run x") == "");
    CHECK(names_in(temporary.path()) == std::set<std::string>{"run"});
    CHECK(names_in(folder) == std::set<std::string>{"summary.json", "junit.xml", "series.csv", "timing.csv", "events.bin",
                                                    "resolved.toml", "figure-1a-left.svg", "figure-1b-left.svg",
                                                    "figure-2to4.svg", "error-over-time.svg", "underruns.csv",
                                                    "report.html"});
    for (const auto& entry : fs::directory_iterator(folder)) CHECK(entry.file_size() >= 45);  // at least a header
  }
}

TEST_CASE("a run has the figure of the study beside it, if that is one of the same scenario, and of no other") {
  const TemporaryFolder temporary;
  const Scenario scenario = read("paper/figure-1-spring.toml", {"run.duration=\"0.6 s\""});
  const Scenario same = read("paper/figure-1-spring.toml", {"run.duration=\"0.6 s\"", "study.repeats=3"});
  const Scenario other = read("paper/figure-1-spring.toml", {"run.duration=\"0.7 s\""});
  CHECK(subject_of(same) == subject_of(scenario));
  CHECK(subject_of(other) != subject_of(scenario));
  const RunOutcome outcome = run_scenario(scenario, {});
  const std::string folder = temporary / "run", figure = folder + "/" + kStudyFigure;
  const auto store = [&](const Scenario& studied) {
    const std::string json = fmt::format("{{\"subject\":\"{:016x}\"}}\n", subject_of(studied));
    REQUIRE(write_folder(folder + "-study", {{kStudyFile, json}, {kStudyFigure, "<svg/>"}}) == "");
  };
  store(other);
  CHECK(write_run_folder(folder, scenario, outcome, "evenstep run x") == "");
  CHECK_FALSE(fs::exists(figure));
  store(same);
  CHECK(write_run_folder(folder + "/", scenario, outcome, "evenstep run x") == "");
  CHECK(fs::file_size(figure) == 6);
}

TEST_CASE("a run that keeps no rows has no events, but shows its error over time") {
  const TemporaryFolder temporary;
  const Scenario scenario = read("paper/figure-1-spring.toml", {"run.duration=\"0.6 s\""});
  RunOutcome outcome = run_scenario(scenario, {});
  outcome.record.keep_rows = false;
  const std::string folder = temporary / "run";
  CHECK(write_run_folder(folder, scenario, outcome, "evenstep run x") == "");
  const std::set<std::string> names = names_in(folder);
  CHECK(names.count("error-over-time.svg") == 1);
  CHECK(names.count("series.csv") == 1);
  CHECK(names.count("events.bin") == 0);
}

TEST_CASE("the timing of a record has its steps in their segments and keeps the idle rest") {
  StrategyRecord strategy;
  strategy.segments = {{4, {0}, {100}, {{RealTime{0}, RealTime{30}}}},
                       {5, {100}, {200}, {{RealTime{180}, RealTime{200}}}},
                       {6, {200}, {210}, std::nullopt}};
  strategy.steps = {{4, {30}, {50}, {}, {}}, {4, {55}, {90}, {}, {}}, {5, {110}, {180}, {}, {}}};
  CHECK(format_timing_csv(recorded_timing(strategy)) ==
        "segment,kind,index,begin_ns,end_ns\n"
        "4,visualization,0,0,30\n4,step,0,30,50\n4,step,1,55,90\n4,idle,0,90,100\n"
        "5,segment,0,100,200\n5,step,0,110,180\n5,visualization,0,180,200\n"
        "6,idle,0,200,210\n");
}

TEST_CASE("a folder that is not a run folder is left alone") {
  const TemporaryFolder temporary;
  const fs::path precious = temporary.path() / "precious";
  fs::create_directories(precious);
  std::ofstream(precious / "thesis.txt") << "irreplaceable";
  const Scenario scenario = read("paper/figure-1-spring.toml", {"run.duration=\"0.6 s\""});
  CHECK_THAT(run_folder_objection(precious.string()), Catch::Contains("not a run folder"));
  CHECK_THAT(write_run_folder(precious.string(), scenario, run_scenario(scenario, {}), ""), Catch::Contains("left alone"));
  CHECK(names_in(precious) == std::set<std::string>{"thesis.txt"});
  CHECK(names_in(temporary.path()) == std::set<std::string>{"precious"});
}

TEST_CASE("processes that write one folder at once all succeed, beside others that are killed, and leave one whole folder") {
  const TemporaryFolder temporary;
  const std::string folder = temporary / "run";
  std::vector<pid_t> writers;
  for (int i = 0; i < 4; ++i) writers.push_back(writer_of(folder, 300));
  for (int i = 0; i < 50; ++i) {
    const pid_t victim = writer_of(folder, 1'000'000);
    std::this_thread::sleep_for(std::chrono::microseconds(500 + 137 * i));
    REQUIRE(::kill(victim, SIGKILL) == 0);
    CHECK(status_of(victim) == SIGKILL);
  }
  for (const pid_t writer : writers) CHECK(status_of(writer) == 0);
  CHECK(content_of(fs::path(folder) / kSummaryFile) == content_of(fs::path(folder) / "second"));
  CHECK(write_folder(folder, {{kSummaryFile, "last"}}) == "");
  CHECK(names_in(folder) == std::set<std::string>{kSummaryFile});
  CHECK(names_in(temporary.path()) == std::set<std::string>{"run"});
}

TEST_CASE("the timing of a run replays to the same steps") {
  const TemporaryFolder temporary;
  const std::vector<std::string> set{"run.duration=\"0.7 s\"", "expect=[]", "run.strategies=[\"direct\"]",
                                     "run.live=\"direct\"",
                                     "timing.jitter={ visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" }"};
  const Scenario scenario = read("paper/figure-1-spring.toml", set);
  const RunOutcome outcome = run_scenario(scenario, {});
  const std::string folder = temporary / "run";
  REQUIRE(write_run_folder(folder, scenario, outcome, "") == "");
  std::ofstream(temporary.path() / "again.toml")
      << "format = 1\nname = \"again\"\n[run]\nstrategies = [\"direct\"]\nlive = \"direct\"\n[timing]\ntrace = "
         "\"run/timing.csv\"\n"
         "[scene]\nsolver = \"cpu-double\"\nkind = \"spring\"\nstiffness = \"200 N/m\"\nstep_size = \"450 Hz\"\n"
         "[[device]]\nname = \"left\"\nrate = \"1 kHz\"\nmotion = { kind = \"still\" }\n";
  const ReadResult again = read_scenario(temporary / "again.toml");
  for (const Diagnostic& error : again.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(again);
  const auto& first = outcome.record.strategies[0].steps;
  const RunRecord replayed_run = run_all(*again);
  const auto& second = replayed_run.strategies[0].steps;
  REQUIRE(second.size() + 1 >= first.size());  // the trace may lack the last step, which completes after the end
  for (std::size_t n = 0; n < second.size(); ++n) {
    REQUIRE(first[n].begin == second[n].begin);
    REQUIRE(first[n].end == second[n].end);
  }
}

TEST_CASE("a visualization beside the steps begins in the record when it began, not when a step let it be seen") {
  const TemporaryFolder temporary;
  const Scenario scenario = read("paper/figure-1-spring.toml",
                                 {"run.duration=\"1 s\"", "expect=[]", "run.strategies=[\"direct\"]", "run.live=\"direct\"",
                                  "timing={ order = \"concurrent\", visualization = \"11.1 ms\", steps = 15, "
                                  "jitter = { visualization = \"lognormal 10 %\", step = \"lognormal 10 %\" } }"});
  const RunRecord run = run_all(scenario);
  const StrategyRecord& direct = run.strategies[0];
  const std::unique_ptr<StepTiming> timing = make_timing(scenario.timing);
  REQUIRE(direct.segments.size() > 20);
  std::int64_t within_a_step = 0;
  SegmentTiming programmed;
  for (const SegmentRow& row : direct.segments) {
    REQUIRE(timing->next(programmed));
    REQUIRE(row.visualization);
    REQUIRE(row.begin == programmed.begin);
    REQUIRE(row.visualization->front() == programmed.visualization->begin);
    REQUIRE(row.end == programmed.end);
    for (const StepRow& step : direct.steps) within_a_step += step.begin < row.begin && row.begin < step.end;
  }
  CHECK(within_a_step > 10);  // segments for which measured and programmed rows could differ
}

TEST_CASE("rows in files or in memory, all kept or a summary: the same trace, metrics and verdicts", "[sweep]") {
  const TemporaryFolder temporary;
  const auto judged = [&](const std::string& keep, bool in_files) {
    const Scenario scenario = read("timing/jitter-10.toml", {"run.duration=\"30 s\"", "run.keep=\"" + keep + "\""});
    RunOptions options;
    options.growths = true;
    if (in_files) options.control.row_files = std::make_shared<RowFiles>(temporary.path());
    RunOutcome outcome = run_scenario(scenario, options);
    for (auto& [signal, values] : outcome.metrics) values.erase("solver_seconds");
    std::erase_if(outcome.metrics, [](const auto& metric) { return metric.first.starts_with("events."); });
    return outcome;
  };
  const RunOutcome expected = judged("all", false);
  for (const RunOutcome& outcome : {judged("all", true), judged("summary", true), judged("summary", false)}) {
    CHECK(outcome.record.trace_hash == expected.record.trace_hash);
    CHECK(outcome.metrics == expected.metrics);
    CHECK(outcome.verdict == expected.verdict);
    REQUIRE(outcome.results.size() == expected.results.size());
    for (std::size_t i = 0; i < outcome.results.size(); ++i) {
      CHECK(outcome.results[i].value == expected.results[i].value);
      CHECK(outcome.results[i].where == expected.results[i].where);
    }
  }
  CHECK(fs::is_empty(temporary.path()));
}

TEST_CASE(
    "what JUnit says of a whole run: an error if it broke, a failure if it asserts nothing, passed if it should stop") {
  using Whole = JunitSuite::Whole;
  RunOutcome outcome;
  outcome.verdict = RunVerdict::pass;
  CHECK(junit_suite(outcome, "").whole == Whole::silent);
  outcome.failure = "stopped";
  CHECK(junit_suite(outcome, "").whole == Whole::passed);
  outcome.exit = ExitCode::expectation_failed;
  CHECK(junit_suite(outcome, "").whole == Whole::failed);
  outcome.exit = ExitCode::run_failed;
  CHECK(junit_suite(outcome, "").whole == Whole::broken);
  outcome = {};
  outcome.exit = ExitCode::not_reproducible;
  outcome.repeat_difference = "event 7";
  CHECK(junit_suite(outcome, "").whole == Whole::broken);
  CHECK_THAT(junit_suite(outcome, "").why, Catch::Contains("not reproducible: event 7"));
  outcome = {};
  outcome.exit = ExitCode::expectation_failed;
  outcome.verdict = RunVerdict::none;
  CHECK(junit_suite(outcome, "").whole == Whole::failed);
  outcome = {};
  outcome.exit = ExitCode::interrupted;
  CHECK(junit_suite(outcome, "").whole == Whole::broken);
}
