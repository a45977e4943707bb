
#include "evenstep/pages/campaign_pages.h"
#include "catch.h"

namespace evenstep {
namespace {

using Catch::Contains;

TEST_CASE("the page of a sweep has a row per value, and the worst points with their commands") {
  SweepHeader header;
  header.name = "latency <b>";
  header.seeds = {1, 2};
  header.grid = {{"remap.latency", {"\"5 ms\"", "\"6 ms\""}}};
  SweepSummarizer summarizer(header);
  for (std::int64_t i = 0; i < 4; ++i)
    summarizer.add({.index = i, .verdict = i == 1 ? SweepVerdict::error : SweepVerdict::pass, .failure = "stopped"});
  const std::string page = sweep_page(
      header, summarizer.summary(), [](const SweepPoint&) { return "evenstep run x"; }, "error", "evenstep sweep x");
  CHECK_THAT(page,
             Contains("latency &lt;b&gt;") && Contains("3 of 4 points passed") && Contains("5 ms") && Contains("6 ms"));
  CHECK_THAT(page, Contains("evenstep run x") && Contains("evenstep sweep x") && Contains("verdict error"));
}

TEST_CASE("the page of a sweep says at its top which states no point reached, and has a section of the states") {
  SweepHeader header;
  header.name = "swarm";
  header.seeds = {1, 2};
  header.sometimes = {{"a force is late", "left.force.direct", "late"}, {"a <rare> one", "left.force.direct", "underruns"}};
  SweepSummary summary;
  summary.all.passed = 2;
  summary.reached = {2, 0};
  const auto page = [&] {
    return sweep_page(
        header, summary, [](const SweepPoint&) { return "evenstep run x"; }, "fail", "evenstep sweep x");
  };
  const std::string top =
      "No point reached 1 of 2 states, so the sweep does not test what it is meant to: a &lt;rare&gt; one.";
  summary.complete = true;
  CHECK_THAT(page(), Contains(top) && Contains("id=\"states\"") && Contains("0 of 2") && Contains("verdict fail"));
  summary.complete = false;  // of a sweep that stopped
  CHECK_THAT(page(), !Contains("No point reached") && Contains("not judged, because that takes all points"));
  summary.complete = true;
  summary.reached = {2, 1};
  CHECK_THAT(page(), !Contains("No point reached") && Contains("1 of 2"));
  header.sometimes.clear();
  summary.reached.clear();
  CHECK_THAT(page(), !Contains("id=\"states\""));
}

TEST_CASE("the page of a sweep says what it looked for, that it stopped early, what no point judged, and a swarm's faults") {
  SweepHeader header;
  header.name = "find";
  header.seeds = {1, 2};
  header.grid = {{"remap.latency", {"\"5 ms\"", "\"6 ms\""}}};
  header.expectations = {{"left.force.direct", "late", "ms"}};
  header.swarm = {"timing.spikes", "device.left.faults.0"};
  header.find = SweepHeader::Find{0, true, "6 ms", 0};
  SweepSummary summary;
  summary.values.resize(1);
  summary.stopped = true;
  summary.find = SweepSummary::Find{1, true, 0};
  summary.worst.resize(2);
  summary.worst[0].point.faults_on = {"timing.spikes"};
  summary.worst[0].point.expect.resize(1);
  summary.worst[0].point.expect[0].value = 2.5;
  summary.worst[0].expectation = 0;
  summary.worst[1].point.failure = "stopped";
  const auto page = [&] {
    return sweep_page(
        header, summary, [](const SweepPoint&) { return "again"; }, "fail", "evenstep sweep x");
  };
  CHECK_THAT(page(), Contains("The smallest remap.latency that passes for every seed: <strong>6 ms</strong>"));
  CHECK_THAT(page(), Contains("At most 6 ms was asked for.") && Contains("It stopped early, after 0 of 4 points."));
  CHECK_THAT(page(), Contains("faults: timing.spikes") && Contains("faults: none"));
  CHECK_THAT(page(), Contains("</code> late 2.5 ms") && Contains("not run"));
  summary.judged = {0};
  CHECK_THAT(page(), !Contains("No point judged"));  // of a sweep that stopped
  summary.complete = true;
  CHECK_THAT(page(), Contains("No point judged left.force.direct late, as it applied to none."));
  header.find->smallest = false;
  CHECK_THAT(page(), Contains("The largest remap.latency") && Contains("At least 6 ms was asked for."));
  summary.find->value.reset();
  CHECK_THAT(page(), Contains("that passes for every seed: none."));
}

TEST_CASE("studies and sizes have pages without a verdict, with their tables") {
  StiffnessLimits limits;
  limits.scenario = "stiff";
  limits.limits = {{"direct", StiffnessLimit::State::found, 194, 195, 0, 9}};
  CHECK_THAT(stiffness_page(limits, "evenstep study x"),
             Contains("194") && Contains("direct") && !Contains("class=\"verdict"));
  FeltStudyRecord felt;
  felt.scenario = "felt";
  CHECK_THAT(felt_study_page(felt, "evenstep study x"), Contains("felt") && Contains("<svg"));
  StudyRecord study;
  study.scenario = "study";
  CHECK_THAT(study_page(study, "evenstep study x"), Contains("study") && Contains("<svg"));
  SizeRecord size;
  size.input = "timing.csv";
  CHECK_THAT(size_page(size, "evenstep size x"), Contains("timing.csv") && Contains("taut string"));
  limits.limits = {{"below", StiffnessLimit::State::below, 11111, 22222, 0, 9},
                   {"above", StiffnessLimit::State::above, 33333, 44444, 0, 9}};
  limits.interrupted = true;
  const std::string page = stiffness_page(limits, "");
  CHECK_THAT(page, !Contains("11111") && Contains("22222") && Contains("33333") && !Contains("44444"));
  CHECK_THAT(page, Contains("what was not measured is missing"));
}

}  // namespace
}  // namespace evenstep
