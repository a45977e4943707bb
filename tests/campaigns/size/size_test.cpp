// What `evenstep size` says, compared with the formulas and with the functions of which it is made.
#include "evenstep/campaigns/size.h"

#include <algorithm>

#include "cases.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/remap/buffer_oracle.h"
#include "evenstep/remap/paper_map.h"
#include "evenstep/remap/phase_locked_map.h"
#include "evenstep/remap/step_windows.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::testing;
using Catch::Contains;

namespace {

const ProgrammedTiming kReference{.segment = {30, 1}, .visualization = {11'100'000}, .steps = {15}};

std::vector<StepTimes> flat(const std::vector<SegmentTiming>& segments) {
  std::vector<StepTimes> steps;
  for (const SegmentTiming& segment : segments) {
    for (const Interval& step : segment.steps) steps.push_back({step.begin, step.end, segment.index, 0});
  }
  return steps;
}

std::vector<MappedStep> mapped(SlotMap&& map, const std::vector<SegmentTiming>& segments) {
  std::vector<MappedStep> steps;
  std::int64_t n = 0;
  for (const SegmentTiming& segment : segments) {
    map.boundary(n, segment.begin);
    for (const Interval& step : segment.steps) {
      const Slot slot = map.read(n, step.begin);
      map.emission(n, step.end);
      if (slot.kind == SlotKind::mapped) steps.push_back({n, step.begin, step.end, slot.read});
      ++n;
    }
  }
  return steps;
}

std::string written(const std::vector<SegmentTiming>& segments, bool visualizations) {
  std::string text = "segment,kind,index,begin_ns,end_ns\n";
  const auto row = [&](std::int64_t segment, const char* kind, std::size_t index, Interval interval) {
    text += std::to_string(segment) + "," + kind + "," + std::to_string(index) + "," + std::to_string(interval.begin.ns) +
            "," + std::to_string(interval.end.ns) + "\n";
  };
  std::size_t index = 0;
  for (const SegmentTiming& segment : segments) {
    if (visualizations) index = 0;
    if (visualizations && segment.visualization) row(segment.index, "visualization", 0, *segment.visualization);
    for (const Interval& step : segment.steps) row(visualizations ? segment.index : 0, "step", index++, step);
  }
  return text;
}

}  // namespace

TEST_CASE("the reference case needs 12.842 ms and any path 2.482 ms in every window") {
  const SizeRecord record = size_segments(play(kReference, 300), "reference", {});
  CHECK(record.steps == 4500);
  CHECK(record.segments == 300);
  CHECK(record.held.best_line.latency.ns == 12'842'223);  // s + Z (1 - 1/N) + h - 1 ns, the ceiling of floors
  CHECK(record.held.taut_string.latency.ns == 1'482'223 + 999'999);
  CHECK(record.held.best_line.windows.p50.ns == 12'842'223);
  CHECK(record.held.best_line.windows.most.ns == 12'842'223);
  CHECK_FALSE(record.linear);
  for (const char* name : {"paper", "phase_locked"}) {
    const SizeStrategy& one = strategy(record, name);
    CHECK(std::abs(one.any_phase.latency.ns - 12'842'222) <= 1);
    CHECK(std::abs(one.latency_this_phase.ns - 12'693'333) <= 1);  // a tick is at the begin of segment 0
    CHECK(std::abs(one.lead.ns - 260'000) <= 1);
    CHECK(one.interaction_capacity == 14);
    CHECK(one.force_capacity == 7);
    // Half a slot is added, from the mean of 4499 distances. They lack one pause of 10.4 ms, which makes 2.3 us each.
    CHECK(std::abs(one.any_phase.total_delay.ns - (12'842'222 + 1'111'111)) <= 1'200);
    // b / (h/2 + L + tau/2): 1 / 14.453 ms
    CHECK(one.any_phase.stiffness_limit_N_per_m == Approx(69.2).margin(0.01));
  }
  REQUIRE(record.cycle);
  CHECK(record.cycle->found);
  CHECK(record.cycle->steps_per_segment == 15);
}

TEST_CASE("interpolated forces need one slot more and no half slot of a staircase is added to their delay") {
  const SizeRecord record = size_segments(play(kReference, 300), "reference", {.emission = Emission::linear});
  CHECK(record.held.best_line.latency.ns == 12'842'223);
  REQUIRE(record.linear);
  CHECK(std::abs(record.linear->best_line.latency.ns - 15'064'445) <= 1);
  for (const SizeStrategy& one : record.strategies) {
    CHECK(std::abs(one.any_phase.latency.ns - 15'064'446) <= 2);
    CHECK(one.any_phase.total_delay == one.any_phase.latency);
    CHECK(one.any_phase.stiffness_limit_N_per_m == Approx(64.2).margin(0.1));
  }
}

TEST_CASE("the stiffness is proportional to the damping and the device period counts twice") {
  const auto segments = play(kReference, 100);
  const SizeRecord one = size_segments(segments, "", {}), five = size_segments(segments, "", {.damping_N_s_per_m = 5});
  CHECK(five.held.best_line.stiffness_limit_N_per_m == Approx(5 * one.held.best_line.stiffness_limit_N_per_m));
  const SizeRecord slow = size_segments(segments, "", {.sampling = {125, 1}});
  CHECK(slow.sampling_period.ns == 8'000'000);
  CHECK((slow.held.best_line.latency - one.held.best_line.latency).ns == 7'000'000);
  const double delay_s = seconds(slow.held.best_line.total_delay);
  CHECK(slow.held.best_line.stiffness_limit_N_per_m == Approx(1 / (0.004 + delay_s)));
}

TEST_CASE("every number is what the oracle and the budgets say of 150 random timings") {
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(150); ++seed) {
    const auto segments = play(random_timing(seed), 60);
    const Emission emission = seed % 2 == 0 ? Emission::hold : Emission::linear;
    const SizeRecord record = size_segments(segments, "", {.emission = emission});
    INFO("seed " << seed);
    std::vector<StepTimes> steps = flat(segments);
    REQUIRE(record.held.best_line.latency == best_line(steps).latency + Duration{999'999});
    REQUIRE(record.held.taut_string.latency == least_path(steps).latency + Duration{999'999});
    REQUIRE(record.linear.has_value() == (emission == Emission::linear));
    interpolate(steps);
    if (record.linear) REQUIRE(record.linear->best_line.latency == best_line(steps).latency + Duration{999'999});
    const SamplingGrid grid{{1000, 1}, {}};
    const std::vector<MappedStep> maps[]{mapped(PaperMap({}, {}, 0.1), segments), mapped(PhaseLockedMap({}, {}), segments)};
    for (std::size_t i = 0; i < 2; ++i) {
      const LatencyBudget any = least_latency_any_phase(maps[i], std::span(&grid, 1), emission);
      const LatencyBudget here = least_latency_this_phase(maps[i], std::span(&grid, 1), emission);
      const SizeStrategy& one = record.strategies[i];
      REQUIRE(one.any_phase.latency == any.latency);
      REQUIRE(one.latency_this_phase == here.latency);
      REQUIRE(one.lead == any.lead);
      REQUIRE(one.lead_culprit == any.lead_culprit);
      REQUIRE(one.any_phase.culprit.step == any.latency_culprit);
      REQUIRE(one.interaction_capacity == static_cast<std::int64_t>(any.interaction_capacity));
      REQUIRE(one.force_capacity == static_cast<std::int64_t>(any.force_capacity));
      // This does not hold for `paper`: a window begins without the repair of a force that stepped back before the window.
      if (one.name == "phase_locked") REQUIRE(one.any_phase.windows.most <= one.any_phase.latency);
      REQUIRE(one.any_phase.windows.p50 <= one.any_phase.windows.p99);
      // No scheme beats the taut string. A map is judged only from its first complete segment on, so the string here is
      // taken over the same steps.
      std::vector<StepTimes> judged;
      for (const MappedStep& step : maps[i]) judged.push_back({step.begin, step.end});
      REQUIRE(one.any_phase.latency >= least_path(judged).latency + Duration{999'999});
    }
  }
}

TEST_CASE("the windows of every row are those of its steps taken alone and their ranks are the nearest") {
  const auto ranks = [](std::vector<Duration> latencies) {
    std::sort(latencies.begin(), latencies.end());
    const auto n = static_cast<std::int64_t>(latencies.size());
    const auto rank = [&](std::int64_t percent) {
      return latencies[static_cast<std::size_t>((percent * n + 99) / 100 - 1)];
    };
    return std::vector<std::int64_t>{rank(50).ns, rank(99).ns, latencies.back().ns, n};
  };
  const auto found = [](const SizeWindows& windows) {
    return std::vector<std::int64_t>{windows.p50.ns, windows.p99.ns, windows.most.ns, windows.count};
  };
  for (const Emission emission : {Emission::hold, Emission::linear}) {
    const auto segments = play({.visualization_variation = 0.2, .step_variation = 0.2, .spikes = Spikes{2, {9 * ms}}}, 900);
    const SizeRecord record = size_segments(segments, "", {.emission = emission});
    const Duration term{999'999};
    std::vector<StepTimes> steps = flat(segments);
    if (emission == Emission::linear) interpolate(steps);
    std::vector<Duration> lines, paths;
    for (const auto& [from, to] : step_windows(std::span<const StepTimes>(steps))) {
      const auto part = std::span(steps).subspan(from, to - from);
      lines.push_back(best_line(part).latency + term);
      paths.push_back(least_path(part).latency + term);
    }
    REQUIRE(lines.size() > 100);  // so that p99 is not the largest
    const SizeBounds& bounds = record.linear ? *record.linear : record.held;
    CHECK(found(bounds.best_line.windows) == ranks(lines));
    CHECK(found(bounds.taut_string.windows) == ranks(paths));
    // With interpolation, it is the end of the following step that is late.
    const std::int64_t behind = emission == Emission::linear ? 1 : 0;
    CHECK(bounds.best_line.culprit.step == best_line(steps).latency_culprit + behind);
    CHECK(bounds.taut_string.culprit.step == least_path(steps).latency_culprit + behind);
    const std::vector<MappedStep> locked = mapped(PhaseLockedMap({}, {}), segments);
    const SamplingGrid grid{{1000, 1}, {}};
    std::vector<Duration> maps;
    for (const auto& [from, to] : step_windows(std::span<const MappedStep>(locked)))
      maps.push_back(
          least_needs_any_phase(std::span(locked).subspan(from, to - from), std::span(&grid, 1), emission).latency);
    CHECK(found(strategy(record, "phase_locked").any_phase.windows) == ranks(maps));
  }
}

TEST_CASE("a step that ends with the run or after it is not judged and one that ends 1 ns before is") {
  Scenario scenario;
  scenario.timing.programmed = {
      .segment = {1000, 32}, .visualization = {8 * ms}, .steps = {16}, .step = Duration{1'500'000}};
  scenario.devices.emplace_back();
  const std::int64_t end = 10 * 32 * ms;  // the end of the last step of segment 9
  for (const std::int64_t more : {-1, 0, 1}) {
    scenario.run_duration = {end + more};
    CHECK(size_scenario(scenario, {}).record.steps == (more > 0 ? 160 : 159));
  }
}

TEST_CASE("a bare list has the bounds of its recording and the segments of the cycle found in it") {
  const auto segments = play({.visualization = {9 * ms},
                              .steps = {8},
                              .step = Duration{2 * ms},
                              .visualization_variation = 0.1,
                              .step_variation = 0.05},
                             100);
  const TimingCsv bare = parse_timing_or_steps(written(segments, false), "bare");
  REQUIRE(bare);
  REQUIRE(bare->size() == 1);
  const SizeRecord with = size_segments(segments, "", {}), without = size_segments(*bare, "", {});
  CHECK(without.segments_from == "cycle");
  CHECK(without.segments == 100);  // the list begins with the first of 8 steps
  CHECK(without.left_out == 0);
  CHECK(without.held.best_line.latency == with.held.best_line.latency);
  CHECK(without.held.taut_string.latency == with.held.taut_string.latency);
  CHECK(without.held.best_line.culprit.step == with.held.best_line.culprit.step);
}

TEST_CASE("a list that begins in the middle of a cycle is sized from the first pause on and counts steps from its begin") {
  auto segments = play(kReference, 60);
  segments.front().steps.erase(segments.front().steps.begin(), segments.front().steps.begin() + 10);
  Interval& late = segments[30].steps[4];  // step 5 + 29 * 15 + 4 of the list
  late.end = segments[30].steps[5].begin = late.end + Duration{1 * ms};
  const SizeRecord record = size_segments(*parse_timing_or_steps(written(segments, false), "bare"), "", {});
  CHECK(record.left_out == 5);
  CHECK(record.segments == 59);
  CHECK(record.steps == 59 * 15);
  CHECK(record.held.taut_string.culprit.step == 5 + 29 * 15 + 4);
  CHECK(record.held.taut_string.culprit.late_step == 5 + 29 * 15 + 4);
  segments.erase(segments.begin());
  const SizeRecord whole = size_segments(*parse_timing_or_steps(written(segments, false), "bare"), "", {});
  CHECK(whole.left_out == 0);
  for (std::size_t i = 0; i < 2; ++i) CHECK(record.strategies[i].lead_culprit == whole.strategies[i].lead_culprit + 5);
}

TEST_CASE("without a cycle every step is a segment and that is said") {
  const SizeRecord record =
      size_segments(play({.visualization = {}, .steps = {500}, .step = Duration{1 * ms}, .step_variation = 0.1}, 1), "", {});
  CHECK(record.segments_from == "step");
  CHECK(record.segments == 500);
  REQUIRE(record.cycle);
  CHECK_FALSE(record.cycle->found);
  CHECK_THAT(size_text(record), Contains("none: no pause between steps stands out"));
}

TEST_CASE("the other jumps that size tries are such as a scenario takes") {
  for (const auto& [set, half, twice] : {std::tuple("0.07", 0.035, 0.14), {"0.8", 0.4, 1.0}, {"0.01", 0.01, 0.02}}) {
    const ReadResult scenario = read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/paper/figure-1-spring-hold.toml",
                                              {{std::string("remap.jump=") + set, "run.duration=\"1 s\""}});
    REQUIRE(scenario);
    const std::vector<SizePath> jumps = size_scenario(*scenario, {}).record.other_jumps;
    REQUIRE(jumps.size() == 2);
    CHECK(jumps[0].jump == Approx(half));
    CHECK(jumps[1].jump == Approx(twice));
  }
}

TEST_CASE("a list of begins and ends is read like timing.csv and its mistakes are named") {
  const auto error = [](const std::string& text) {
    const TimingCsv csv = parse_timing_or_steps(text, "list.csv");
    return csv ? "" : evenstep::text(csv.error().front());
  };
  CHECK(parse_timing_or_steps("begin_ns,end_ns\n100,150\n160,200\r\n", "list.csv")->front().steps[1].begin.ns == 60);
  CHECK_THAT(error("begin_ns,end_ns\n"), Contains("no rows"));
  CHECK_THAT(error("begin_ns,end_ns\n5,4\n"), Contains("list.csv:2:3: error: ends at 4 ns, before it begins at 5 ns"));
  CHECK_THAT(error("begin_ns,end_ns\n5,9\n8,10\n"),
             Contains("list.csv:3:1: error: begins at 8 ns, before the step before it"));
  CHECK_THAT(error("begin_ns,end_ns\n5,9,1\n"), Contains("3 cells, where a row has 2"));
  CHECK_THAT(error("begin_ns,end_ns\n5,x\n"), Contains("'x' is not a whole number"));
  CHECK_THAT(error("begin_ns,end_ns\n0,1000000000000001\n"), Contains("longer than 1e6 s"));
  CHECK_THAT(error("begin,end\n5,9\n"), Contains("the first line must be segment,kind"));
}
