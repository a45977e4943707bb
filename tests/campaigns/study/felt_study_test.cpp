// The error of the felt force and its parts, where closed forms or other runs say what they must be.
#include <algorithm>
#include <cmath>
#include <string_view>

#include "evenstep/campaigns/felt_study.h"
#include "evenstep/harness/sizing.h"
#include "src/felt/runs.h"
#include "study_scenes.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

using State = StudyCell::State;

Scenario read_shipped(const std::string& file, const std::vector<std::string>& set) {
  const ReadResult result = read_scenario(std::string(EVENSTEP_SOURCE_DIR) + "/scenarios/" + file, {set, std::nullopt});
  for (const Diagnostic& error : result.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(result);
  return *result;
}

/// 200 N/m under a hand that moves evenly along x, in the timing of the paper.
Scenario spring(const std::string& velocity = "0.1 m/s", const std::vector<std::string>& set = {}) {
  std::vector<std::string> all{
      "run.duration=\"1 s\"", "study.repeats=1",
      "device.left.motion={ kind = \"constant-velocity\", velocity = [\"" + velocity + "\", \"0 m/s\", \"0 m/s\"] }"};
  all.insert(all.end(), set.begin(), set.end());
  return read_shipped("paper/figure-1-spring.toml", all);
}

/// A block of 5 x 5 x 5 in the timing of the paper. One corner of its top is dragged.
Scenario block(const std::vector<std::string>& set = {}) {
  std::vector<std::string> all{"run.duration=\"0.36 s\"",
                               "run.warmup=\"9 segments\"",
                               "scene.solver=cpu",
                               "scene.lattice=[5, 5, 5]",
                               "scene.particles=125",
                               "scene.stiffness=\"5 N/m\"",
                               "device.left.grab={ center = [\"10 mm\", \"10 mm\", \"20 mm\"], radius = \"5.5 mm\" }",
                               "device.right.grab={ center = [\"0 mm\", \"0 mm\", \"20 mm\"], radius = \"5.5 mm\" }",
                               "study.solvers=[\"cpu-double\"]",
                               "study.repeats=1"};
  all.insert(all.end(), set.begin(), set.end());
  Scenario scenario = read_shipped("paper/figure-1.toml", all);
  scenario.strategies = {StrategyKind::ideal, StrategyKind::direct, StrategyKind::phase_locked};
  return scenario;
}

const FeltPoint& point_of(const FeltStudyRecord& study, std::string_view strategy, std::size_t nth = 0) {
  for (const FeltPoint& point : study.points) {
    if (point.strategy == strategy && nth-- == 0) return point;
  }
  FAIL("no such point");
  return study.points.front();
}

/// The ages of the forces that `direct` plays at the judged ticks, computed from the timing alone. Each tick plays the force
/// of the last step that has ended, and that step read the hand when it began.
std::vector<double> ages_of_direct(const Scenario& scenario) {
  std::vector<Interval> steps;
  const auto timing = make_timing(scenario.timing);
  SegmentTiming segment;
  while (timing->next(segment) && segment.begin < RealTime{scenario.run_duration.ns})
    steps.insert(steps.end(), segment.steps.begin(), segment.steps.end());
  std::vector<double> ages;
  for (RealTime t = tick_time({1000, 1}, first_tick_at_or_after({1000, 1}, RealTime{scenario.warmup.ns}));
       t < RealTime{scenario.run_duration.ns}; t = t + Duration{1'000'000}) {
    const auto after =
        std::upper_bound(steps.begin(), steps.end(), t, [](RealTime at, const Interval& step) { return at < step.end; });
    ages.push_back(seconds(t - (after - 1)->begin));
  }
  return ages;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("A spring under an even hand has no discretisation, whatever the strategy, and a remapped one feels the line") {
  const FeltStudyRecord study = run_felt_study(spring());
  CHECK(study.points.size() == 3);  // a spring has no method and no steps; `ideal` is what the others are compared with
  CHECK(study.reference.estimate_N < 1e-7);
  for (const FeltPoint& point : study.points) {
    INFO(point.strategy);
    REQUIRE(point.state == State::measured);
    CHECK(point.discretisation.max_N < 1e-11);  // rounding of 20 N
    if (point.strategy == "direct") continue;
    CHECK(point.remap.max_N <= 200 * 0.1 * 2e-9);  // slots are whole nanoseconds, and so are ticks
    CHECK(point.latency_s == Approx(0.015064446).margin(1e-9));
  }
}

TEST_CASE("What direct makes of an even hand on a spring follows from the times of its steps alone") {
  const Scenario scenario = spring();
  const FeltStudyRecord study = run_felt_study(scenario);
  const std::vector<double> ages = ages_of_direct(scenario);
  const double age = mean(ages), k_v = 200 * 0.1;
  double sum = 0, most = 0;
  for (const double one : ages) {
    sum += (one - age) * (one - age);
    most = std::max(most, std::abs(one - age));
  }
  const FeltPoint& direct = point_of(study, "direct");
  CHECK(direct.latency_s == Approx(age).epsilon(1e-9));
  CHECK(direct.remap.rms_N == Approx(k_v * std::sqrt(sum / static_cast<double>(ages.size()))).epsilon(1e-6));
  CHECK(direct.remap.max_N == Approx(k_v * most).epsilon(1e-6));
}

TEST_CASE("With reports of whole nanometres and micronewtons the device's part is at most half of each") {
  const double k = 200;
  // At 0.1 m/s every sample is a whole number of nanometres, so only the force is rounded.
  const FeltPoint exact = point_of(run_felt_study(spring("0.1 m/s")), "phase_locked");
  CHECK(exact.device.max_N <= 0.5e-6 * (1 + 1e-6));
  CHECK(exact.device.max_N > 0);
  // A step reads between two samples. Both are off by half a nanometre at most, and along x only.
  const FeltPoint odd = point_of(run_felt_study(spring("0.0987654321 m/s")), "phase_locked");
  CHECK(odd.device.max_N <= (0.5e-6 + k * 0.5e-9) * (1 + 1e-6));
  CHECK(odd.device.rms_N > exact.device.rms_N * 0.9);
  CHECK(exact.device_latency_s == Approx(0).margin(1e-9));  // a lead covers the wait for a sample
}

TEST_CASE("A device that answers at its ticks makes direct older by the wait for a sample, and that is latency, not error") {
  const Scenario scenario = spring();
  const FeltPoint direct = point_of(run_felt_study(scenario), "direct");
  CHECK(direct.device_latency_s > 0.2e-3);  // half a millisecond on average over all phases
  CHECK(direct.device_latency_s < 0.8e-3);
  // The jitter of the wait is error. Each wait is shorter than a period of 1 ms, and their mean is the latency.
  const double farthest_s = std::max(direct.device_latency_s, 1e-3 - direct.device_latency_s);
  CHECK(direct.device.max_N < 200 * 0.1 * farthest_s + 1e-6);
  CHECK(direct.device.rms_N > 1e-4);
}

TEST_CASE("A force that is felt later is latency, not error") {
  const FeltPoint now = point_of(run_felt_study(spring()), "phase_locked");
  const FeltPoint later = point_of(run_felt_study(spring("0.1 m/s", {"device.left.delay=\"2 ms\""})), "phase_locked");
  CHECK(later.device_latency_s == Approx(now.device_latency_s + 0.002).margin(1e-9));
  CHECK(later.total.rms_N < 1e-6);
}

TEST_CASE("Held emission is discretisation: the saw-tooth of a slot") {
  // k v h / sqrt(12), sampled at 1 kHz
  const FeltPoint held = point_of(
      run_felt_study(spring("0.1 m/s", {"device.left.render={ kind = \"force\", emission = \"hold\" }"})), "phase_locked");
  CHECK(held.discretisation.rms_N == Approx(200 * 0.1 / 450 / std::sqrt(12)).epsilon(0.02));
  CHECK(held.remap.rms_N < 0.02 * held.discretisation.rms_N);
}

TEST_CASE("A guard that limits the force is the device's part, and is counted") {
  const FeltPoint clamped = point_of(run_felt_study(spring("0.1 m/s", {"device.left.force_limit=\"5 N\""})), "phase_locked");
  CHECK(clamped.saturated > 100);
  CHECK(clamped.device.max_N > 1);
  CHECK(clamped.remap.max_N < 1e-6);
  CHECK_THAT(felt_study_table(run_felt_study(spring("0.1 m/s", {"device.left.force_limit=\"5 N\""}))),
             Contains("met a limit"));
}

TEST_CASE("The parts add up: no felt error is larger than its parts together, and none of them exceeds the others and it",
          "[sweep]") {
  const FeltStudyRecord study = run_felt_study(block());
  CHECK(study.points.size() == 2 * 9);  // two strategies, three methods, three steps
  for (const FeltPoint& point : study.points) {
    INFO(point.strategy << " " << point.method << " " << point.substep_s);
    REQUIRE(point.state == State::measured);
    const double d = point.discretisation.rms_N, r = point.remap.rms_N, v = point.device.rms_N, e = point.total.rms_N;
    CHECK(e <= (d + r + v) * (1 + 1e-12));
    CHECK(d <= (e + r + v) * (1 + 1e-12));
    CHECK(r <= (e + d + v) * (1 + 1e-12));
    CHECK(v <= (e + d + r) * (1 + 1e-12));
    CHECK(point.total.max_N >= e);
  }
}

TEST_CASE("Of a tissue a shorter step has less discretisation, and the strategy decides on the remap", "[sweep]") {
  const FeltStudyRecord study = run_felt_study(block({"study.methods=[\"symplectic-euler\", \"implicit-euler\"]"}));
  for (const char* strategy : {"direct", "phase_locked"}) {
    for (const std::size_t method : {0, 3}) {
      for (std::size_t i = 1; i < 3; ++i) {
        const FeltPoint &coarse = point_of(study, strategy, method + i - 1), &fine = point_of(study, strategy, method + i);
        INFO(strategy << " " << fine.method << " " << fine.substep_s);
        CHECK(fine.substep_s < coarse.substep_s);
        CHECK(fine.discretisation.rms_N < coarse.discretisation.rms_N);
      }
    }
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const FeltPoint &direct = point_of(study, "direct", i), &locked = point_of(study, "phase_locked", i);
    CHECK(locked.remap.rms_N < 0.01 * direct.remap.rms_N);
    CHECK(locked.total.rms_N < direct.total.rms_N);
    // Both are compared with the same even steps, except that they are looked at with a different lead and latency.
    CHECK(direct.discretisation.rms_N == Approx(locked.discretisation.rms_N).epsilon(0.3));
  }
}

TEST_CASE("A study judges what the run judges, or the part of it that its duration says, and says so") {
  const FeltStudyRecord all = run_felt_study(spring());
  CHECK(all.judged_from_s == Approx(8 / 30.0));
  CHECK(all.judged_to_s == 1);
  CHECK(all.ticks == 733);  // 0.267, 0.268, ... 0.999
  CHECK_THAT(felt_study_table(all), Contains("all that the run judges"));
  const FeltStudyRecord part = run_felt_study(spring("0.1 m/s", {"study.duration=\"0.1 s\""}));
  CHECK(part.judged_to_s == Approx(8 / 30.0 + 0.1));
  CHECK(part.ticks == 100);
  CHECK_THAT(felt_study_table(part), Contains("the first 0.1 s of the 0.733333 s that the run judges"));
}

TEST_CASE("Figure 1 has three methods by three steps, over its own judged motion") {
  const Scenario scenario = read_shipped("paper/figure-1.toml", {});
  CHECK(scenario.study.error == StudyError::felt_force);
  CHECK(scenario.study.methods == std::vector<Method>{Method::symplectic_euler, Method::rk4, Method::implicit_euler});
  const internal::JudgedSpan span = internal::judged_span(scenario);
  CHECK(span.from.ns == scenario.warmup.ns);
  CHECK(span.end.ns == scenario.run_duration.ns);
  CHECK(seconds(span.from) > 0.3);  // from here on the hands are at full speed
}

TEST_CASE("The cost is announced before anything else: of the reference, of each point, and of all together", "[sweep]") {
  std::vector<std::string> lines;
  double begun = -1;
  FeltStudyControl control;
  control.announce = [&](const std::string& line) {
    CHECK(begun < 0);
    lines.push_back(line);
  };
  control.progress = [&](double fraction) { begun = fraction; };
  run_felt_study(block(), control);
  REQUIRE(lines.size() == 1 + 9 + 1);
  CHECK_THAT(lines.front(), Contains("reference") && Contains("CPU s"));
  for (std::size_t i = 1; i < 10; ++i) CHECK_THAT(lines[i], Contains("point") && Contains("CPU s with every strategy"));
  CHECK_THAT(lines.back(), Contains("all") && Contains("CPU s"));
}

TEST_CASE("What a solver refuses is a point with its reason, and so is what diverges") {
  const FeltStudyRecord refused =
      run_felt_study(block({"study.methods=[\"symplectic-euler\"]", "study.step_sizes=[\"450 Hz\", \"1800 Hz\"]"}));
  REQUIRE(refused.points.size() == 4);
  CHECK(point_of(refused, "direct", 0).state == State::refused);
  CHECK(point_of(refused, "direct", 1).state == State::measured);
  CHECK_THAT(felt_study_table(refused), Contains("refused: "));
  const FeltStudyRecord diverged =
      run_felt_study(block({"study.methods=[\"symplectic-euler\"]", "study.step_sizes=[\"450 Hz\"]",
                            "scene.allow_unstable=true", "scene.stiffness=\"50 N/m\""}));
  for (const FeltPoint& point : diverged.points) CHECK(point.state == State::diverged);
}

TEST_CASE("The errors of the felt force are the same again, bit for bit, and its text and figure have every point") {
  const Scenario scenario = block({"study.methods=[\"symplectic-euler\"]"});
  const FeltStudyRecord first = run_felt_study(scenario), again = run_felt_study(scenario);
  REQUIRE(first.points.size() == again.points.size());
  for (std::size_t i = 0; i < first.points.size(); ++i) {
    CHECK(first.points[i].total.rms_N == again.points[i].total.rms_N);
    CHECK(first.points[i].remap.max_N == again.points[i].remap.max_N);
  }
  const std::string csv = felt_study_csv(first);
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 6);
  CHECK_THAT(felt_study_json(first), Contains("\"discretisation\":{\"rms_N\":"));
  CHECK_THAT(felt_study_svg(first), Contains("felt error, rms") && Contains("phase_locked") && Contains("latency 15.064"));
}

TEST_CASE("An interrupted study of the felt force has the points so far, and says so") {
  std::atomic<bool> interrupted{false};
  FeltStudyControl control;
  control.interrupted = &interrupted;
  control.progress = [&](double fraction) { interrupted = fraction > 0; };
  const FeltStudyRecord study = run_felt_study(block({"study.methods=[\"symplectic-euler\"]"}), control);
  CHECK(study.interrupted);
  CHECK(study.points.size() == 2);  // a cell, with two strategies
  CHECK_THAT(felt_study_table(study), Contains("interrupted: points are missing"));
  const FeltAdvice advice = advise(study, *parse_goal("100000 % force"));  // both points would do
  CHECK_FALSE(advice.found);
  CHECK_THAT(advice.text, Contains("no advice on 100000 % force: the study was interrupted"));
  interrupted = true;
  const FeltStudyRecord none = run_felt_study(block(), control);
  CHECK(none.points.empty());
  CHECK_THAT(felt_study_table(none), Contains("reference    none: it was interrupted") && !Contains("now stored"));
}

TEST_CASE("There is no study of a force whose hand gives way to it, of a local model, or of the ideal alone") {
  Scenario ideal = spring();
  ideal.strategies = {StrategyKind::ideal};
  CHECK_THAT(felt_study_objection(ideal), Contains("name another strategy"));
  Scenario nothing = spring();
  nothing.warmup = nothing.run_duration;
  CHECK_THAT(felt_study_objection(nothing), Contains("judges nothing"));
  Scenario hand = spring();
  hand.devices[0].hand = HandSpec{};
  CHECK_THAT(felt_study_objection(hand), Contains("held by a hand that feels the force"));
  CHECK_THROWS_AS(run_felt_study(hand), std::invalid_argument);
  Scenario local = spring();
  local.devices[0].render = LocalRender{};
  CHECK_THAT(felt_study_objection(local), Contains("local model"));
  CHECK(felt_study_objection(spring()).empty());
}

TEST_CASE("The advice is the cheapest point within the error, and of one cost that with the least error") {
  FeltStudyRecord study;
  study.reference.scale_N = 2;
  study.reference.estimate_N = 1e-6;
  const auto add = [&](const char* strategy, double error_N, double cpu) {
    FeltPoint& point = study.points.emplace_back();
    point.strategy = strategy;
    point.method = "rk4";
    point.solver = "cpu";
    point.total.rms_N = error_N;
    point.cpu = {cpu, cpu, cpu};
  };
  add("direct", 0.1, 1);
  add("paper", 0.015, 1);
  add("phase_locked", 0.01, 1);
  add("phase_locked", 0.001, 3);
  const FeltAdvice one = advise(study, *parse_goal("1 % force"));
  CHECK(one.found);
  CHECK_THAT(one.text, Contains("phase_locked") && Contains("0.5 %") && Contains("1 CPU seconds"));
  CHECK_THAT(advise(study, *parse_goal("0.1 % force")).text, Contains("3 CPU seconds"));
  CHECK_FALSE(advise(study, *parse_goal("0.01 % force")).found);
  CHECK_THAT(advise(study, *parse_goal("0.00001 % force")).text, Contains("cannot tell"));
  CHECK_FALSE(advise(study, *parse_goal("1 % position")).found);
}
