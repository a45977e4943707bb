// What `advise` says of a timing agrees with what the scenario of each row gives, and with the laws and the sizing.
#include "evenstep/campaigns/advise.h"

#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "catch.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "evenstep/harness/run.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/recordings/timing_csv.h"
#include "temporary_folder.h"

using namespace evenstep;
using Catch::Contains;
using evenstep::testing::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

constexpr const char* kRecorded = EVENSTEP_SOURCE_DIR "/scenarios/recorded/";

std::string content(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// The first segments of a shipped recording.
std::vector<SegmentTiming> first_segments(const std::string& name, std::size_t count) {
  TimingCsv csv = read_timing_csv(kRecorded + name + ".csv");
  REQUIRE(csv);
  csv->resize(std::min(csv->size(), count));
  return *csv;
}

std::string part_of(const TemporaryFolder& place, const std::string& name, std::size_t segments) {
  return place.write(name + ".csv", format_timing_csv(first_segments(name, segments)));
}

/// A list of steps at even gaps, without pauses.
std::string without_pauses(const TemporaryFolder& place) {
  std::string csv = "begin_ns,end_ns\n";
  for (std::int64_t n = 0; n < 3200; ++n) {
    const std::int64_t begin = n * 2'000'000 + (n * 7919 % 97) * 3'000;
    csv += fmt::format("{},{}\n", begin, begin + 1'500'000);
  }
  return place.write("even.csv", csv);
}

AdviseResult advised(const std::string& file, const AdviseOptions& options = {}) {
  AdviseResult result = advise_recording(file, options);
  for (const Diagnostic& error : result.errors) UNSCOPED_INFO(text(error));
  REQUIRE(result.errors.empty());
  REQUIRE_FALSE(result.interrupted);
  return result;
}

/// Options with one bandwidth and no change of the simulator.
AdviseOptions as_it_is() {
  AdviseOptions options;
  options.bandwidths = {{2, 1}};
  options.renderers = {"hold", "local"};
  options.governors.emplace();
  return options;
}

double value_of(const RunOutcome& run, const AdviceChoice& choice, const char* device, const char* kind,
                const char* metric) {
  return run.metrics.at(fmt::format("{}.{}.{}", device, kind, choice.map)).at(metric);
}

/// Checks the scenario that shows how far something runs on when a hand stops.
void check_stops(const std::string& folder, const AdviceChoice& choice) {
  const ReadResult scenario = read_scenario((fs::path(folder) / stops_file(choice)).string());
  REQUIRE(scenario);
  REQUIRE(scenario->expectations.size() == 1);
  const RunOutcome run = run_scenario(*scenario, {});
  CHECK(run.verdict == RunVerdict::pass);
  CHECK(value_of(run, choice, "stops", "interaction", "error_max") == choice.stop_error_m);
}

/// Runs the scenario of a row as `evenstep run` does, and compares the results with the row.
void check_row(const std::string& folder, const AdviceChoice& choice) {
  INFO("choice " << choice.number << ": " << name_of(choice) << " " << choice.failure);
  REQUIRE(choice.failure.empty());
  const ReadResult scenario = read_scenario((fs::path(folder) / choice_file(choice)).string());
  REQUIRE(scenario);
  REQUIRE(scenario->expectations.size() >= 5);
  const RunOutcome run = run_scenario(*scenario, {});
  for (const ExpectationResult& result : run.results) {
    if (result.verdict != ExpectationResult::Verdict::pass)
      UNSCOPED_INFO(result.signal << " " << result.metric << " " << result.value.value_or(-1) << " " << result.detail);
  }
  CHECK(run.verdict == RunVerdict::pass);
  const double speed = std::get<ConstantVelocity>(scenario->devices.front().motion.shape).velocity_m_per_s.x;
  const Rate rate = scenario->scene.step_rate;
  const double step_m = speed * static_cast<double>(rate.den) / static_cast<double>(rate.num);
  CHECK(value_of(run, choice, "line", "interaction", "velocity_jump") ==
        Approx(choice.jump_step * step_m).epsilon(1e-12).margin(0));
  CHECK(value_of(run, choice, "line", "force", "velocity_jump") ==
        Approx(choice.force_jump_step * step_m * choice.tried_N_per_m).epsilon(1e-12).margin(0));
  CHECK(value_of(run, choice, "line", "buffers", "underrun_rate") == choice.underrun_rate);
  const double most_s = seconds(choice.latency_most.value_or(choice.latency));
  CHECK(value_of(run, choice, "closed_loop", "hand", "loop_delay") - (most_s - seconds(choice.latency)) ==
        Approx(choice.delay_s).epsilon(1e-12));
  if (choice.searched)
    CHECK(value_of(run, choice, "closed_loop", "hand", "predicted_stiffness_limit") >= choice.stiffness_N_per_m * 0.995);
  else
    CHECK(value_of(run, choice, "closed_loop", "hand", "predicted_stiffness_limit") == choice.stiffness_N_per_m);
  if (choice.comes_to_rest) CHECK((value_of(run, choice, "closed_loop", "hand", "stable") > 0) == *choice.comes_to_rest);
  CHECK(run.record.strategies.front().latency.latency == choice.latency_most.value_or(choice.latency));
  if (choice.latency_most)
    CHECK(value_of(run, choice, "line", "force", "schedule_latency_mean") == Approx(seconds(choice.latency)).margin(1e-9));
  if (choice.map == "predict") check_stops(folder, choice);
  CHECK(run.record.strategies.front().latency.lead == choice.lead);
}

void check_all_rows(const std::string& file, const AdviseOptions& options = {}) {
  const TemporaryFolder place;
  const AdviseResult result = advised(file, options);
  const std::string folder = place / "out";
  REQUIRE(write_advice_folder(folder, result, "again").empty());
  REQUIRE(result.record.choices.size() >= 8);
  for (const AdviceChoice& choice : result.record.choices) check_row(folder, choice);
}

}  // namespace

TEST_CASE("the scenario of every row gives the numbers of the row") {
  const TemporaryFolder place;
  SECTION("paced segments") { check_all_rows(part_of(place, "small-paced30-basic", 220)); }
  SECTION("free running, with a jittering pace") { check_all_rows(part_of(place, "paperlike-free-basic", 250)); }
  SECTION("a shared machine") { check_all_rows(part_of(place, "contended-free-basic", 110)); }
}

TEST_CASE("the scenario of every row gives its numbers where nothing pauses, and paper is left out") {
  const TemporaryFolder place;
  const std::string file = without_pauses(place);
  check_all_rows(file);
  const AdviseResult result = advised(file);
  CHECK(result.record.segments_from == "step");
  for (const AdviceChoice& choice : result.record.choices) CHECK(choice.map != "paper");
  REQUIRE_FALSE(result.record.notes.empty());
  CHECK_THAT(result.record.notes.front(), Contains("No pause stands out"));
}

TEST_CASE("a scenario says with keys what a governor of a run can do, and these give the schedule that was priced") {
  const TemporaryFolder place;
  const std::string name = GENERATE(as<std::string>{}, "paced30-pthread", "regime-free-basic");
  constexpr std::size_t kSegments = 120;
  AdviseOptions options;
  options.renderers = {"hold"};
  options.governors.emplace();
  for (const char* text :
       {"split 2", "budget 21 ms", "budget 30 ms hold", "budget 30 ms skip, forecast 3", "pace 90 %",
        "split 3, budget 8 ms, pace 25 Hz", "own-lane 1.3", "budget 10 s", "spread", "spread, split 2, budget 12 ms"})
    options.governors->push_back(parse_what_if(text).value());
  const std::string file = part_of(place, name, kSegments);
  const AdviseResult result = advised(file, options);
  const std::string folder = place / "out";
  REQUIRE(write_advice_folder(folder, result, "again").empty());
  // Two timings have no keys: own-lane, which no governor can do, and a budget that `governor` in [timing] refuses.
  CHECK(result.timings.size() == 3);
  const std::vector<SegmentTiming> segments = first_segments(name, kSegments);
  std::size_t with_keys = 0;
  for (const AdviceChoice& choice : result.record.choices) {
    if (choice.governor.empty()) continue;
    INFO(name << ", " << name_of(choice));
    check_row(folder, choice);
    const ReadResult scenario = read_scenario((fs::path(folder) / choice_file(choice)).string());
    REQUIRE(scenario);
    const bool by_keys = scenario->timing.governor.has_value();
    CHECK(by_keys == (choice.governor != "own-lane 1.3" && choice.governor != "budget 10000 ms merge"));
    with_keys += by_keys ? 1 : 0;
    const WhatIf what_if = parse_what_if(choice.governor).value();
    const Result<WhatIfTiming> priced = evenstep::apply(causal(what_if).value_or(what_if), segments, true);
    REQUIRE(priced);
    const auto timing = make_timing(scenario->timing);
    std::vector<SegmentTiming> given;
    for (SegmentTiming segment; timing->next(segment);) given.push_back(segment);
    CHECK(format_timing_csv(given) == format_timing_csv(priced->segments));
  }
  CHECK(with_keys == 8);
}

TEST_CASE("a latency that adapts is at most the fixed one, and carries as much") {
  const TemporaryFolder place;
  const AdviseResult result = advised(part_of(place, "contended-free-basic", 250), as_it_is());
  std::size_t adaptive = 0, less = 0;
  for (const AdviceChoice& choice : result.record.choices) {
    if (!choice.adaptive) continue;
    INFO(name_of(choice));
    const auto same = std::find_if(result.record.choices.begin(), result.record.choices.end(), [&](const AdviceChoice& one) {
      return !one.adaptive && one.accepted_rate == 0 && one.governor.empty() && one.map == choice.map &&
             one.bandwidth_Hz == choice.bandwidth_Hz && one.renderer == choice.renderer;
    });
    REQUIRE(same != result.record.choices.end());
    CHECK(*choice.latency_most == same->latency);
    CHECK(choice.latency <= same->latency);
    CHECK(choice.delay_s - same->delay_s == Approx(seconds(choice.latency) - seconds(same->latency)).margin(1e-12));
    CHECK(choice.stiffness_N_per_m == Approx(same->stiffness_N_per_m));
    less += choice.delay_s < 0.98 * same->delay_s ? 1 : 0;
    ++adaptive;
  }
  CHECK(adaptive == 2);
  CHECK(less == 2);
}

TEST_CASE("what predict carries is the largest stiffness that study finds stable, and it runs on by its horizon") {
  const TemporaryFolder place;
  const std::string folder = place / "out";
  const AdviseResult result = advised(part_of(place, "paced30-pthread", 220), as_it_is());
  REQUIRE(write_advice_folder(folder, result, "again").empty());
  std::size_t predicted = 0;
  for (const AdviceChoice& choice : result.record.choices) {
    INFO(name_of(choice));
    CHECK(fs::exists(fs::path(folder) / stops_file(choice)) == (choice.map == "predict"));
    CHECK(choice.searched == (choice.map == "predict"));
    if (choice.map != "predict") {
      CHECK(choice.runs_on_s == 0);
      continue;
    }
    ReadResult scenario = read_scenario((fs::path(folder) / choice_file(choice)).string());
    REQUIRE(scenario);
    CHECK(run_stiffness_limits(*scenario).limits.front().stable_N_per_m == choice.stiffness_N_per_m);
    CHECK(choice.comes_to_rest == true);
    // It reads at least -c ahead of its slot, from a sample that is up to a period old.
    CHECK(choice.lead.ns < 0);
    CHECK(choice.runs_on_s <= 0.06);
    CHECK(choice.runs_on_s >= 0.5 * -seconds(choice.lead));
    ++predicted;
  }
  CHECK(predicted == 2);
}

/// The row of this map and renderer, with its scenario.
std::pair<AdviceChoice, Scenario> row_of(const std::string& folder, const AdviseResult& result, const std::string& map,
                                         const std::string& renderer) {
  for (const AdviceChoice& choice : result.record.choices) {
    if (choice.map != map || choice.renderer != renderer || choice.adaptive || choice.accepted_rate > 0) continue;
    ReadResult scenario = read_scenario((fs::path(folder) / choice_file(choice)).string());
    REQUIRE(scenario);
    return {choice, *std::move(scenario)};
  }
  FAIL("no row of " << map << ", " << renderer);
  std::abort();
}

TEST_CASE("the search for what predict carries begins with what the map carries without it, and needs few runs") {
  const TemporaryFolder place;
  const std::string folder = place / "out";
  const AdviseResult result = advised(part_of(place, "paced30-pthread", 220), as_it_is());
  REQUIRE(write_advice_folder(folder, result, "again").empty());
  const auto [held, held_scenario] = row_of(folder, result, "predict", "hold");
  const auto without = row_of(folder, result, "phase_locked", "hold").first;
  CHECK(held_scenario.study.stiffness_limit->from_N_per_m == Approx(without.stiffness_N_per_m).epsilon(0.005));
  CHECK(held.stiffness_N_per_m > 2 * without.stiffness_N_per_m);
  CHECK(run_stiffness_limits(held_scenario).limits.front().runs <= 20);
  // With the map, the local model carries as much as the value at which this search ends. Then the search begins at half of
  // that.
  const auto [local, local_scenario] = row_of(folder, result, "predict", "local");
  const StiffnessSearch& search = *local_scenario.study.stiffness_limit;
  CHECK(search.from_N_per_m == Approx(search.to_N_per_m / 2).epsilon(0.005));
  CHECK(run_stiffness_limits(local_scenario).limits.front().runs <= 20);
}

TEST_CASE("where predict carries less than the map without it, the search finds how much all the same") {
  const TemporaryFolder place;
  const std::string folder = place / "out";
  AdviseOptions options = as_it_is();
  options.renderers = {"hold"};
  options.mass_kg = 5;  // predict replaces a negative damper by a negative mass; this hand has little friction for its mass
  const AdviseResult result = advised(part_of(place, "paced30-pthread", 220), options);
  REQUIRE(write_advice_folder(folder, result, "again").empty());
  const auto [held, scenario] = row_of(folder, result, "predict", "hold");
  const auto without = row_of(folder, result, "phase_locked", "hold").first;
  CHECK(held.failure == "");
  CHECK(held.comes_to_rest == true);
  CHECK(held.stiffness_N_per_m > 1);
  CHECK(held.stiffness_N_per_m < without.stiffness_N_per_m);
  CHECK(scenario.study.stiffness_limit->from_N_per_m == 1);
  CHECK(run_stiffness_limits(scenario).limits.front().stable_N_per_m == held.stiffness_N_per_m);
}

TEST_CASE("the bytes of an advice are the same with one thread and with four") {
  const TemporaryFolder place;
  const std::string file = part_of(place, "small-paced30-basic", 60);
  AdviseOptions one, four;
  one.threads = 1;
  four.threads = 4;
  REQUIRE(write_advice_folder(place / "one", advised(file, one), "again").empty());
  REQUIRE(write_advice_folder(place / "four", advised(file, four), "again").empty());
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(place / "one")) {
    INFO(entry.path());
    CHECK(content(entry.path()) == content(fs::path(place / "four") / entry.path().filename()));
    ++files;
  }
  CHECK(files >= 18);
}

TEST_CASE("latency and bound are those that size finds, and no latency is below its bound") {
  const TemporaryFolder place;
  const std::string file = part_of(place, "paced30-pthread", 200);
  const AdviseResult result = advised(file);
  const SizeRecord sized = size_recording(file, {}).record;
  const SizeStrategy* use = nullptr;
  for (const SizeStrategy& strategy : sized.strategies) use = strategy.name == "phase_locked" ? &strategy : use;
  REQUIRE(use != nullptr);
  std::size_t with_bound = 0, compared = 0;
  for (const AdviceChoice& choice : result.record.choices) {
    INFO(name_of(choice));
    if (choice.bound) {
      CHECK(choice.latency >= *choice.bound);
      ++with_bound;
    }
    if (name_of(choice) != "phase_locked 2 Hz, hold") continue;
    CHECK(choice.latency == use->any_phase.latency);
    CHECK(choice.lead == use->lead);
    CHECK(*choice.bound == use->path->latency);
    CHECK(choice.unseen->late == use->all_unseen().late);
    CHECK(choice.unseen->late_by == use->all_unseen().late_by);
    // Samples are 1 ms apart and in whole nanometres, so the run shows the jump of the map and little more.
    CHECK(choice.jump_step == Approx(use->velocity_jump).margin(0.01));
    ++compared;
  }
  CHECK(with_bound >= 6);
  CHECK(compared == 1);
}

TEST_CASE("the stiffness carried is that of the laws for the latency of the row") {
  const TemporaryFolder place;
  AdviseOptions options;
  options.damping_N_s_per_m = 1.5;
  options.mass_kg = 0.3;
  const AdviseResult result = advised(part_of(place, "small-paced30-basic", 100), options);
  std::size_t held = 0, sprung = 0;
  for (const AdviceChoice& choice : result.record.choices) {
    INFO(name_of(choice));
    if (choice.searched) continue;  // there is no law for it
    if ((choice.renderer == "hold" || choice.renderer == "linear") && !choice.adaptive) {
      CHECK(choice.stiffness_N_per_m == Approx(1.5 / choice.delay_s).epsilon(1e-9));  // K_max = b / L_e
      ++held;
    }
    if (choice.map != "direct" && choice.renderer == "hold" && choice.governor.empty() && !choice.adaptive)
      CHECK(choice.delay_s == Approx(seconds(choice.latency) + seconds(result.record.slot) / 2 + 0.5e-3).epsilon(1e-3));
    if (choice.renderer == "device_spring") {
      CHECK(choice.stiffness_N_per_m >= 2 * 1.5 / 1e-3);  // 2 b / h of the host, at least
      ++sprung;
    }
    CHECK(choice.tried_N_per_m == Approx(0.8 * choice.stiffness_N_per_m).epsilon(0.005));
  }
  CHECK(held >= 6);
  CHECK(sprung >= 3);
}

TEST_CASE("the second latency is lower, and no more segments are late than were accepted") {
  const TemporaryFolder place;
  AdviseOptions options;
  options.rate = 0.05;
  const AdviseResult result = advised(part_of(place, "paced30-pthread", 300), options);
  std::size_t late = 0;
  for (const AdviceChoice& choice : result.record.choices) {
    INFO(name_of(choice));
    if (choice.accepted_rate == 0) {
      if (choice.map != "direct" && !choice.adaptive) CHECK(choice.underrun_rate == 0);
      continue;
    }
    CHECK(choice.accepted_rate == 0.05);
    CHECK(choice.late_any_phase > 0);
    CHECK(choice.late_any_phase <= 0.05);
    CHECK(choice.underrun_rate <= 0.05 * 1.25);  // the share of judged segments, which exclude the first second
    const auto same = std::find_if(result.record.choices.begin(), result.record.choices.end(), [&](const AdviceChoice& one) {
      return one.accepted_rate == 0 && !one.adaptive && one.map == choice.map && one.bandwidth_Hz == choice.bandwidth_Hz &&
             one.renderer == choice.renderer;
    });
    REQUIRE(same != result.record.choices.end());
    CHECK(choice.latency < same->latency);
    ++late;
  }
  CHECK(late == 2);
}

TEST_CASE("a recording of a few seconds is not long enough to see a hand come to rest, and that is said") {
  const TemporaryFolder place;
  const AdviseResult few = advised(part_of(place, "small-paced30-basic", 110));
  CHECK_THAT(few.record.notes.front(), Contains("After 3.64 s nobody can tell") && Contains("Record 6 s or more"));
  for (const AdviceChoice& choice : few.record.choices) CHECK_FALSE(choice.comes_to_rest.has_value());
  CHECK(choice_to_use(few.record, true) != nullptr);
  const AdviseResult more = advised(part_of(place, "small-paced30-basic", 220));
  CHECK(more.record.notes.empty());
  for (const AdviceChoice& choice : more.record.choices) {
    INFO(name_of(choice));
    // This recording idles. A choice with its own pace makes it shorter.
    if (choice.governor.empty() && choice.failure.empty()) CHECK(choice.comes_to_rest == true);
  }
}

TEST_CASE("a rate that is less than one segment is left out, and that is said") {
  const TemporaryFolder place;
  const AdviseResult result = advised(part_of(place, "small-paced30-basic", 40));
  for (const AdviceChoice& choice : result.record.choices) CHECK(choice.accepted_rate == 0);
  REQUIRE_FALSE(result.record.notes.empty());
  CHECK_THAT(result.record.notes.back(), Contains("1 % of 40 segments is less than one"));
}

TEST_CASE("a scenario is advised with its timing and its slowest device") {
  const ReadResult scenario = read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/paper/figure-1-spring-hold.toml",
                                            {{"device.0.rate=500 Hz", "run.duration=3 s"}, std::nullopt, {}});
  REQUIRE(scenario);
  AdviseOptions options;
  options.renderers = {"hold"};
  const AdviseResult result = advise_scenario(*scenario, options);
  REQUIRE(result.errors.empty());
  CHECK(result.record.sampling_period == Duration{2'000'000});
  const SizeRecord sized = size_scenario(*scenario, {}).record;
  for (const AdviceChoice& choice : result.record.choices) {
    if (choice.map == "paper") CHECK(choice.latency == sized.strategies.front().any_phase.latency);
  }
}

TEST_CASE("a scenario whose forces travel from a source is not advised as if they did not") {
  const ReadResult scenario = read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/sources/slower.toml", {});
  REQUIRE(scenario);
  const AdviseResult result = advise_scenario(*scenario, {});
  REQUIRE(result.errors.size() == 1);
  CHECK(result.record.choices.empty());
  CHECK_THAT(text(result.errors.front()), Contains("slower.toml") && Contains("[source]") && Contains("`size`"));
}

TEST_CASE("a scenario whose samples have an age of their own is advised without it, and that is said") {
  AdviseOptions options;
  options.renderers = {"hold"};
  options.governors.emplace();
  const auto notes_of = [&](const char* age) {
    const ReadResult scenario =
        read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/paper/figure-1-spring-hold.toml",
                      {{"run.duration=3 s", std::string("device.0.report_age=") + age}, std::nullopt, {}});
    REQUIRE(scenario);
    const AdviseResult result = advise_scenario(*scenario, options);
    REQUIRE(result.errors.empty());
    return fmt::format("{}", fmt::join(result.record.notes, " "));
  };
  CHECK_THAT(notes_of("0.3 ms"), Contains("left out") && Contains("those of left (up to 0.301 ms)"));
  CHECK_THAT(notes_of("0 ms"), !Contains("age"));
}

TEST_CASE("what cannot be advised says why, and what to do") {
  const TemporaryFolder place;
  const auto refused = [&](const std::string& file) {
    const AdviseResult result = advise_recording(file, {});
    REQUIRE(result.errors.size() == 1);
    CHECK(result.record.choices.empty());
    return text(result.errors.front());
  };
  CHECK_THAT(refused(place / "nowhere.csv"), Contains("nowhere.csv"));
  CHECK_THAT(refused(part_of(place, "small-paced30-basic", 2)), Contains("too short to advise") && Contains("record more"));
  CHECK_THAT(refused(place.write("one.csv", "begin_ns,end_ns\n0,5\n")), Contains("too short to advise"));
  CHECK_THAT(refused(place.write("drawn.csv", "segment,kind,index,begin_ns,end_ns\n0,visualization,0,0,5\n")),
             Contains("there is no step in it"));
  std::string long_one = "begin_ns,end_ns\n";
  for (std::int64_t n = 0; n <= kMostAdviceSteps; ++n) long_one += fmt::format("{},{}\n", n * 1'000'000, n * 1'000'000 + 5);
  CHECK_THAT(refused(place.write("long.csv", long_one)), Contains("give a part of them"));
}

TEST_CASE(
    "a recording of a game's loop has clocked among its choices once its step size is told, and the row runs as it says") {
  const TemporaryFolder place;
  const auto frames = make_programmed_timing({.segment = {60, 1},
                                              .visualization = {4'000'000},
                                              .steps = {1},
                                              .step = Duration{500'000},
                                              .order = SegmentOrder::steps_first,
                                              .paced = true,
                                              .accumulator = Accumulator{.step_rate = {90, 1}}});
  std::vector<SegmentTiming> segments(480);
  for (SegmentTiming& segment : segments) {
    REQUIRE(frames->next(segment));
    segment.simulated.clear();
  }
  const std::string file = place.write("game.csv", format_timing_csv(segments));
  AdviseOptions options = as_it_is();
  const auto clocked = [](const AdviceRecord& record) -> const AdviceChoice* {
    for (const AdviceChoice& choice : record.choices)
      if (choice.map == "clocked" && choice.renderer == "hold") return &choice;
    return nullptr;
  };
  CHECK(clocked(advised(file, options).record) == nullptr);
  options.step_size = Rate{90, 1};
  const AdviseResult result = advised(file, options);
  const AdviceChoice* const choice = clocked(result.record);
  REQUIRE(choice);
  SizeOptions size;
  size.step_size = options.step_size;
  size.sampling = options.sampling;
  for (const SizeStrategy& strategy : size_recording(file, size).record.strategies)
    if (strategy.name == "clocked") CHECK(choice->latency == strategy.any_phase.latency);
  CHECK(choice->jump_step < 1e-3);
  CHECK(choice->latency < choice_to_use(advised(file, as_it_is()).record, false)->latency);
  CHECK(choice_to_use(result.record, false)->map == "clocked");
  const std::string folder = place / "advice";
  REQUIRE(write_advice_folder(folder, result, "again").empty());
  const ReadResult scenario = read_scenario((fs::path(folder) / choice_file(*choice)).string());
  REQUIRE(scenario);
  CHECK(run_scenario(*scenario, {}).verdict == RunVerdict::pass);
}

TEST_CASE(
    "a larger jump is a choice where it saves a twentieth of the latency or more, and never the one to use by default") {
  const TemporaryFolder place;
  for (const std::string name : {"contended-free-basic", "paced30-pthread"}) {
    const std::string file = part_of(place, name, 300);
    const AdviceRecord record = advised(file, as_it_is()).record;
    const auto is_usual = [](const AdviceChoice& one) {
      return one.map == "phase_locked" && name_of(one) == "phase_locked 2 Hz, hold";
    };
    const auto is_rougher = [](const AdviceChoice& one) { return one.allowed_jump == 0.14 && one.renderer == "hold"; };
    const auto usual = std::find_if(record.choices.begin(), record.choices.end(), is_usual);
    const auto rougher = std::find_if(record.choices.begin(), record.choices.end(), is_rougher);
    REQUIRE(usual != record.choices.end());
    const std::vector<SizePath> other = size_recording(file, {}).record.other_jumps;
    REQUIRE(other.size() == 2);
    CHECK(other[0].jump == Approx(0.035));
    CHECK(other[1].jump == Approx(0.14));
    const Duration saved = usual->latency - other[1].latency;
    INFO(name << " saves " << saved.ns << " ns of " << usual->latency.ns);
    REQUIRE((rougher != record.choices.end()) == (20 * saved.ns > usual->latency.ns));
    if (rougher == record.choices.end()) continue;
    CHECK(rougher->latency == other[1].latency);
    CHECK(name_of(*rougher) == "phase_locked 2 Hz, jump 0.14, hold");
    CHECK(rougher->jump_step > usual->jump_step);
    CHECK(choice_to_use(record, false)->allowed_jump == 0);
  }
}

TEST_CASE("an advice that is interrupted says so") {
  const TemporaryFolder place;
  const std::atomic<bool> stop{true};
  AdviseOptions options;
  options.interrupted = &stop;
  CHECK(advise_recording(part_of(place, "small-paced30-basic", 40), options).interrupted);
}
