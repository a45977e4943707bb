// What `evenstep fit` says: latencies that are computed by hand, a table that the reader accepts, and a verdict that depends
// on the order of segments.
#include "evenstep/campaigns/fit_report.h"
#include "cases.h"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "catch.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/format/scenario.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/reports/json.h"
#include "evenstep/scheduler/frame_governor.h"
#include "evenstep/scheduler/random.h"
#include "temporary_folder.h"

using namespace evenstep;
using Catch::Contains;

namespace {

constexpr std::int64_t ms = 1'000'000;

std::vector<SegmentTiming> play(const ProgrammedTiming& programmed, std::size_t count) {
  const auto timing = make_programmed_timing(programmed);
  std::vector<SegmentTiming> segments(count);
  for (SegmentTiming& segment : segments) REQUIRE(timing->next(segment));
  return segments;
}

/// Reads the table in the smallest scenario that can contain it.
ReadResult read_table(const std::string& table) {
  const testing::TemporaryFolder folder;
  return read_scenario(folder.write("fit.toml",
                                    "format = 1\n[run]\nduration = \"1 s\"\n[scene]\nkind = \"spring\"\n"
                                    "[[device]]\nname = \"left\"\n" +
                                        table));
}

/// Schedules that together have every part of a fit.
std::vector<ProgrammedTiming> schedules() {
  const ProgrammedTiming base{.step = Duration{1 * ms}, .visualization_variation = 0.05, .step_variation = 0.01};
  std::vector<ProgrammedTiming> all(8, base);
  all[1].steps = {14, 15, 16};
  all[1].first_step = 0.2;
  all[2].order = SegmentOrder::steps_first;
  all[2].spikes = Spikes{20, {4 * ms}};
  all[3].paced = true;
  all[3].preemption = Preemption{5, {3 * ms}, {40 * ms}, 1.5};
  all[4].regimes = Regimes{1.6, 8};
  all[4].drift_per_s = 0.01;
  all[5].dropped_visualization = 0.05;
  all[5].merged_visualization = 0.05;
  all[6].order = SegmentOrder::concurrent;
  all[6].paced = true;
  all[6].slowdown = 1.5;
  all[7].order = SegmentOrder::concurrent;
  return all;
}

}  // namespace

TEST_CASE("latency_need of a periodic schedule is the closed form, in every window and over all of it") {
  // With 50 Hz, V = 8 ms and 4 steps of 3 ms, L* = s + Z (1 - 1/N) = 3 + 8 * 3/4 ms.
  const auto segments = play({.segment = {50, 1}, .visualization = {8 * ms}, .steps = {4}}, 200);
  const LatencyNeed need = latency_need(segments);
  CHECK(need.window_p50.ns == 9 * ms);
  CHECK(need.window_p99.ns == 9 * ms);
  CHECK(need.whole.ns == 9 * ms);
}

TEST_CASE("latency_need takes the median and the worst window: one long visualization in 10 s is in the p99 only") {
  auto segments = play({.segment = {50, 1}, .visualization = {8 * ms}, .steps = {4}}, 500);
  for (SegmentTiming& segment : segments) {
    if (segment.index <= 300) continue;
    for (Interval& step : segment.steps) step = {step.begin + Duration{5 * ms}, step.end + Duration{5 * ms}};
  }
  const LatencyNeed need = latency_need(segments);
  CHECK(need.window_p50.ns == 9 * ms);
  CHECK(need.window_p99.ns > 9 * ms);
  CHECK(need.window_p99.ns <= 14 * ms);
  // A jump of 5 ms comes after 60 % of the time. The line tilts so that each side of the jump takes half of it.
  CHECK(need.whole.ns > 10 * ms);
  CHECK(need.whole.ns < 14 * ms);
  CHECK(latency_need({}).whole.ns == 0);
  CHECK(latency_need(std::span(segments).first(1)).window_p50 == latency_need(std::span(segments).first(1)).whole);
}

TEST_CASE("differences names what is more than half as much again, either way") {
  const LatencyNeed a{{10}, {20}, {30}, {100}};
  CHECK(differences(a, a).empty());
  CHECK(differences(a, {{15}, {30}, {45}, {100}}).empty());
  CHECK(differences(a, {{16}, {30}, {45}, {100}}) == std::vector<std::string>{"250 ms p50"});
  CHECK(differences(a, {{10}, {13}, {46}, {100}}) == std::vector<std::string>{"250 ms p99", "whole recording"});
}

TEST_CASE("differences is stricter with the map that a run uses: its least latency must be within 10 %") {
  const LatencyNeed recording{{10}, {20}, {30}, {153}};
  CHECK(differences(recording, {{10}, {20}, {30}, {140}}).empty());
  CHECK(differences(recording, {{10}, {20}, {30}, {168}}).empty());
  for (const std::int64_t needed : {99, 139, 169})
    CHECK(differences(recording, {{10}, {20}, {30}, {needed}}) == std::vector<std::string>{"phase_locked"});
}

TEST_CASE("latency_need of phase_locked is what size says of the same recording") {
  for (const ProgrammedTiming& programmed : schedules()) {
    const auto segments = play(programmed, 300);
    const SizeRecord record = size_segments(segments, "", {});
    CHECK(record.strategies.back().name == "phase_locked");
    CHECK(latency_need(segments).phase_locked == record.strategies.back().any_phase.latency);
  }
}

TEST_CASE("the table that is proposed is one that the reader accepts, and means the model that was fitted") {
  for (const ProgrammedTiming& programmed : schedules()) {
    const auto segments = play(programmed, 1'000);
    const TimingFit fit = fit_timing(segments);
    const std::string table = fit_toml(fit, compare(fit, segments, 1), "x.csv");
    const ReadResult read = read_table(table);
    std::string errors;
    for (const Diagnostic& error : read.error_or({})) errors += text(error) + "\n";
    INFO(table << errors);
    REQUIRE(read);
    const ProgrammedTiming &in = fit.timing, &out = read->timing.programmed;
    CHECK(out.order == in.order);
    CHECK(out.paced == in.paced);
    CHECK(out.visualization == in.visualization);
    CHECK(out.step == in.step);
    if (in.order != SegmentOrder::concurrent) CHECK(out.steps == in.steps);
    if (in.paced) CHECK(out.segment == in.segment);
    // Ratios are written with three or four digits.
    CHECK(out.visualization_variation == Approx(in.visualization_variation).epsilon(0.01));
    CHECK(out.step_variation == Approx(in.step_variation).epsilon(0.01));
    CHECK(out.first_step == Approx(in.first_step).epsilon(0.01));
    CHECK(out.slowdown == Approx(in.slowdown).epsilon(0.001));
    CHECK(out.drift_per_s == Approx(in.drift_per_s).epsilon(0.001));
    CHECK(out.dropped_visualization == Approx(in.dropped_visualization).epsilon(0.01));
    CHECK(out.merged_visualization == Approx(in.merged_visualization).epsilon(0.01));
    REQUIRE(out.spikes.has_value() == in.spikes.has_value());
    if (in.spikes) CHECK(out.spikes->rate_Hz == Approx(in.spikes->rate_Hz).epsilon(0.001));
    REQUIRE(out.preemption.has_value() == in.preemption.has_value());
    if (in.preemption) CHECK(out.preemption->least == in.preemption->least);
    REQUIRE(out.regimes.has_value() == in.regimes.has_value());
    if (in.regimes) CHECK(out.regimes->mean_length == Approx(in.regimes->mean_length).epsilon(0.001));
    if (in.regimes) CHECK(out.regimes->slow_share == Approx(in.regimes->slow_share).epsilon(0.01));
  }
}

TEST_CASE("a recording whose steps wait for their slots is told to be spread, and its model needs what it needs") {
  const ProgrammedTiming paced{
      .step = Duration{ms / 2}, .visualization_variation = 0.05, .step_variation = 0.01, .paced = true};
  const auto timing = make_governed_timing(make_programmed_timing(paced), {.spread = true}, grid_period(paced));
  std::vector<SegmentTiming> segments(1'000);
  for (SegmentTiming& segment : segments) timing->next(segment);
  const TimingFit fit = fit_timing(segments);
  CHECK(fit.spread);
  CHECK_FALSE(fit_timing(play(paced, 1'000)).spread);
  const FitComparison comparison = compare(fit, segments);
  CHECK(differences(comparison.recording, comparison.model_median).empty());
  const ReadResult read = read_table(fit_toml(fit, comparison, "x.csv"));
  REQUIRE(read);
  REQUIRE(read->timing.governor);
  CHECK(read->timing.governor->spread);
}

TEST_CASE("a recording of a known model is told to be one: model, recording and shuffled need the same") {
  const ProgrammedTiming paced{
      .step = Duration{1 * ms}, .visualization_variation = 0.05, .step_variation = 0.01, .paced = true};
  const auto segments = play(paced, 1'000);
  const TimingFit fit = fit_timing(segments);
  const FitComparison comparison = compare(fit, segments);
  CHECK(differences(comparison.recording, comparison.model_median).empty());
  CHECK(differences(comparison.recording, comparison.shuffled_median).empty());
  const std::string table = fit_toml(fit, comparison, "x.csv");
  CHECK_THAT(table, Contains("This model needs what the recording needs") && !Contains("Replay it"));
  CHECK_THAT(fit_json(fit, comparison, "x.csv"), Contains("\"order_matters\":false,\"replay_instead\":false"));
}

TEST_CASE("shuffling segments that do not depend on each other changes no window and no walk of the boundaries") {
  // Boundaries walk at random by 22 % of 11 ms a segment, and a window of 250 ms holds ten of them. 1000 segments make 100
  // windows, whose medians differ by 3 %.
  const auto segments = play({.step = Duration{1 * ms}, .visualization_variation = 0.22}, 1'000);
  const FitComparison comparison = compare(fit_timing(segments), segments, 15);
  const auto ratio = [](Duration a, Duration b) { return static_cast<double>(a.ns) / static_cast<double>(b.ns); };
  CHECK(ratio(comparison.shuffled_median.window_p50, comparison.recording.window_p50) == Approx(1).margin(0.06));
  CHECK(ratio(comparison.model_median.window_p50, comparison.recording.window_p50) == Approx(1).margin(0.06));
  // From one random walk to the next, the greatest distance varies by half of itself.
  CHECK(ratio(comparison.shuffled_median.whole, comparison.recording.whole) > 0.4);
  CHECK(ratio(comparison.shuffled_median.whole, comparison.recording.whole) < 2.5);
}

TEST_CASE("where a long slow wave is in the recording, order matters and replay is what is proposed") {
  // V rises from 11 to 15 ms within 5 s and falls again, twice. That is neither a drift nor two levels.
  ProgrammedTiming wave{.step = Duration{1 * ms}, .visualization_variation = 0.02, .step_variation = 0.01};
  for (int i = 1; i < 80; ++i)
    wave.changes.push_back(
        {.at = {i * 250 * ms}, .visualization = Duration{(11 + (i % 40 < 20 ? i % 20 : 20 - i % 20) / 4) * ms}});
  const auto segments = play(wave, 700);
  const TimingFit fit = fit_timing(segments);
  const FitComparison comparison = compare(fit, segments);
  const std::string table = fit_toml(fit, comparison, "x.csv");
  INFO(table);
  CHECK(comparison.recording.whole.ns > 2 * comparison.shuffled_median.whole.ns);
  CHECK_THAT(table, Contains("The order of the segments matters") && Contains("trace = \"x.csv\""));
  CHECK_THAT(fit_json(fit, comparison, "x.csv"), Contains("\"order_matters\":true"));
}

TEST_CASE("the comparison is the same on every call, and more seeds keep the first ones") {
  const auto segments = play({.step = Duration{1 * ms}, .visualization_variation = 0.2}, 300);
  const TimingFit fit = fit_timing(segments);
  const FitComparison few = compare(fit, segments, 3), more = compare(fit, segments, 5);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(few.model[i].whole == more.model[i].whole);
    CHECK(few.shuffled[i].whole == more.shuffled[i].whole);
  }
  CHECK(few.model[0].whole != few.model[1].whole);
  CHECK(few.shuffled[0].whole != few.shuffled[1].whole);
}

TEST_CASE("the JSON is JSON, and a file name comes back from it whole, whatever is in it") {
  for (const ProgrammedTiming& schedule : schedules()) {
    const auto segments = play(schedule, 64);
    const TimingFit fit = fit_timing(segments);
    for (const std::string name : {"a\"b\\c.csv", "line\nbreak\x01\x1f tab\t.csv", "\xC2\xB5m \xE6\x97\xA5.csv"}) {
      const Json json = Json::parse(fit_json(fit, compare(fit, segments, 1), name));
      CHECK(json.at("file") == name);
      CHECK(json.at("segments") == fit.segments);
      CHECK(json.at("latency").at("model").size() == 1);
    }
  }
}

namespace {

/// A recording that no renderer would make. Its lengths are drawn from a few, among them 0, 1 ns and 20 s. It has two levels
/// of V that are far apart, pauses, segments without a visualization or without steps, and now and then a visualization
/// beside its steps.
std::vector<SegmentTiming> odd_recording(std::uint64_t seed) {
  const RandomStream stream(seed, "fit.odd");
  std::uint64_t draw = 0;
  const auto pick = [&](std::uint64_t count) { return stream.bits(draw++) % count; };
  constexpr std::int64_t lengths[] = {0, 1, 2, 1000, ms / 2, ms, 3 * ms, 11 * ms, 300 * ms, 20'000 * ms};
  std::int64_t of[4];  // V, slow V, step, pause
  for (std::int64_t& length : of) length = lengths[pick(std::size(lengths))];
  const std::uint64_t most_steps = 1 + pick(6), rare = 1 + pick(40), jitter = 1 + pick(3) * 500'000, count = 33 + pick(200);
  const bool beside = pick(4) == 0, slowly = pick(2) == 0, growing = pick(3) == 0;
  std::vector<SegmentTiming> segments;
  std::int64_t now = 0;
  bool slow = false;
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto about = [&](std::int64_t ns) {
      return (growing ? ns * static_cast<std::int64_t>(k) / 100 : ns) + static_cast<std::int64_t>(pick(jitter));
    };
    SegmentTiming segment{.index = static_cast<std::int64_t>(k), .begin = RealTime{now}};
    if (slowly ? pick(9) == 0 : pick(2) == 0) slow = !slow;
    std::int64_t shown = now;
    if (pick(rare + 1) > 0) {
      shown += about(of[slow ? 1 : 0]);
      segment.visualization = Interval{RealTime{now}, RealTime{shown}};
    }
    if (!beside) now = shown;
    for (std::uint64_t i = pick(rare + 1) > 0 ? 1 + pick(most_steps) : 0; i > 0; --i) {
      const std::int64_t end = now + about(pick(rare + 1) > 0 ? of[2] : 4 * ms);
      segment.steps.push_back({RealTime{now}, RealTime{end}});
      now = end;
    }
    now = std::max(now, shown) + about(of[3]) + 1;
    segment.end = RealTime{now};
    segments.push_back(std::move(segment));
  }
  return segments;
}

}  // namespace

TEST_CASE("2000 odd recordings: no number is nan or infinite, and what is proposed is read, as a model or as a replay") {
  std::uint64_t models = 0, replays = 0;
  for (std::uint64_t seed = 0; seed < evenstep::testing::cases(2'000); ++seed) {
    const TimingCsv csv = parse_timing_csv(format_timing_csv(odd_recording(seed)), "x.csv");
    if (!csv || !fit_objection(*csv).empty()) continue;
    const TimingFit fit = fit_timing(*csv);
    const std::string objection = table_objection(fit);
    const std::string table = fitted_table(fit);
    INFO("seed " << seed << "\n" << table << objection);
    REQUIRE(fit.timing.visualization >= Duration{0});
    for (const char* wrong : {"nan", "inf "}) REQUIRE_THAT(table, !Contains(wrong));
    REQUIRE(read_table("[timing]\n" + table).ok() == objection.empty());
    ++(objection.empty() ? models : replays);
    if (seed % 20 != 0) continue;  // the comparison plays the model
    const FitComparison comparison = compare(fit, *csv, 1);
    const std::string text = fit_toml(fit, comparison, "x.csv");
    CHECK_THAT(text, !Contains("nan"));
    CHECK(Contains("\ntrace = \"x.csv\"").match(text) != objection.empty());
    CHECK_THAT(fit_json(fit, comparison, "x.csv"), !Contains("nan"));
    if (objection.empty()) CHECK(read_table(text));
  }
  CAPTURE(models, replays);
  CHECK(models > evenstep::testing::cases(300));
  CHECK(replays > evenstep::testing::cases(100));
}

TEST_CASE("a model is proposed for a shipped recording only if phase_locked needs what it needs on the recording, to 10 %") {
  const std::filesystem::path folder = std::filesystem::path(EVENSTEP_SOURCE_DIR) / "scenarios/recorded";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".csv") continue;
    INFO(entry.path());
    const TimingCsv csv = read_timing_csv(entry.path().string());
    if (!fit_objection(*csv).empty()) continue;  // too short
    const TimingFit fit = fit_timing(*csv);
    const FitComparison comparison = compare(fit, *csv, 5);
    const double recorded = static_cast<double>(comparison.recording.phase_locked.ns);
    const double ratio = static_cast<double>(comparison.model_median.phase_locked.ns) / recorded;
    const bool proposed = fit_toml(fit, comparison, "x.csv").find("This model needs") != std::string::npos;
    CHECK((!proposed || std::abs(std::log(ratio)) < std::log(1.1)));
    // Whatever the levels of V are, the model has the mean of the recording, except for what is beyond 5 deviations. If the
    // visualization has its own lane, it also differs by what hits take of it.
    if (fit.timing.order == SegmentOrder::concurrent) continue;
    double sum = 0, count = 0;
    for (const SegmentTiming& segment : *csv) {
      if (!segment.visualization) continue;
      sum += static_cast<double>((segment.visualization->end - segment.visualization->begin).ns);
      ++count;
    }
    if (fit.timing.regimes) CHECK(static_cast<double>(fit.timing.visualization.ns) == Approx(sum / count).epsilon(0.04));
  }
}

TEST_CASE("each recording that is shipped is fitted, and its table read") {
  const std::filesystem::path folder = std::filesystem::path(EVENSTEP_SOURCE_DIR) / "scenarios/recorded";
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".csv") continue;
    INFO(entry.path());
    const TimingCsv csv = read_timing_csv(entry.path().string());
    REQUIRE(csv);
    if (csv->size() < 32) continue;  // too short
    REQUIRE(fit_objection(*csv).empty());
    const TimingFit fit = fit_timing(*csv);
    const std::string table = fit_toml(fit, compare(fit, *csv, 1), "x.csv");
    INFO(table);
    CHECK(read_table(table));
    const std::string name = entry.path().filename().string();
    CHECK(fit.timing.paced == (name.starts_with("h") ||
                               (name.find("paced30") != std::string::npos && name.find("concurrent") == std::string::npos)));
    ++count;
  }
  CHECK(count >= 7);
}
