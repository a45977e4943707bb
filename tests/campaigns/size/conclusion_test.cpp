// What `size` prints for pasting makes a scenario that is accepted, needs exactly that latency and has no underrun with it.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/run.h"
#include "evenstep/recordings/timing_csv.h"
#include "temporary_folder.h"
#include "traces.h"

using namespace evenstep;
using namespace evenstep::testing;
using Catch::Contains;
namespace fs = std::filesystem;

namespace {

struct Pasted {
  SizeRecord sized, scenario;
  RunOutcome run;
};

/// Sizes the recording, and runs a scenario that contains what was printed.
Pasted pasted(const std::string& recording, const RecordingOptions& options = {}) {
  Pasted out;
  SizeResult sized = size_recording(recording, {}, options);
  REQUIRE(sized.errors.empty());
  out.sized = sized.record;
  const std::string printed = size_text(out.sized);
  REQUIRE(printed.find("\n[remap]\n") != std::string::npos);
  const TemporaryFolder folder;
  const std::string file = folder / "conclusion.toml";
  std::ofstream(file) << "format = 1\n[run]\nstrategies = [\"" << strategy_to_use(out.sized)->name
                      << "\"]\n[scene]\nkind = \"spring\"\nsolver = \"cpu-double\"\n[[device]]\nname = \"left\"\n"
                         "render = { kind = \"force\", emission = \"hold\" }\n[[expect]]\nsignal = \"left.force."
                      << strategy_to_use(out.sized)->name << "\"\nmetric = \"underruns\"\nequals = 0\n"
                      << printed.substr(printed.find("\n[remap]\n"));
  const ReadResult read = read_scenario(file);
  INFO(printed << (read ? "" : text(read.error().front())));
  REQUIRE(read);
  out.scenario = size_scenario(*read, {}).record;
  out.run = run_scenario(*read, {});
  return out;
}

}  // namespace

TEST_CASE("the tables that size prints are accepted, need the same latency, and run without an underrun") {
  for (const char* name : {"small-paced30-basic", "paperlike-free-basic"}) {
    INFO(name);
    const Pasted out = pasted(EVENSTEP_SOURCE_DIR "/scenarios/recorded/" + std::string(name) + ".csv");
    const SizeStrategy& use = *strategy_to_use(out.sized);
    CHECK(strategy(out.scenario, use.name).any_phase.latency == use.any_phase.latency);
    CHECK(strategy(out.scenario, use.name).lead == use.lead);
    CHECK(out.run.record.strategies.front().latency.latency == use.any_phase.latency);
    CHECK(out.run.verdict == RunVerdict::pass);
  }
}

TEST_CASE(
    "of a recording below two seconds jumps count from its half on, so no map seems smooth because none was looked at") {
  std::vector<SegmentTiming> segments =
      play({.visualization = {10 * ms}, .step = Duration{1 * ms}, .hitch = Hitch{{100 * ms}, {15 * ms}}}, 12);
  const SizeRecord record = size_segments(segments, "short.csv", {});
  REQUIRE(record.length < Duration{1'000'000'000});
  CHECK(strategy(record, "paper").velocity_jump > 0.5);
  CHECK(strategy(record, "phase_locked").velocity_jump < 0.15);
  CHECK(strategy_to_use(record)->name == "phase_locked");
}

TEST_CASE("where there are too few steps to see a jump, no map is called even and none is to be used") {
  std::vector<SegmentTiming> segments = play({.visualization = {10 * ms}, .step = Duration{1 * ms}}, 2);
  segments[1].steps.resize(2);
  const SizeRecord record = size_segments(segments, "short.csv", {});
  for (const SizeStrategy& one : record.strategies) CHECK_FALSE(one.jump_seen);
  CHECK(strategy_to_use(record) == nullptr);
  CHECK_THAT(size_text(record), Contains("No map can be named"));
}

TEST_CASE("a shorter visualization is advised only where there is one") {
  const auto conclusion = [](const ProgrammedTiming& timing) { return size_text(size_segments(play(timing, 90), "", {})); };
  CHECK_THAT(conclusion({.visualization = {10 * ms}, .step = Duration{1 * ms}}), Contains("A shorter visualization helps"));
  CHECK_THAT(conclusion({.visualization = {}, .steps = {1}, .step = Duration{1 * ms}}),
             !Contains("shorter visualization") && Contains("It has no\n  visualization"));
}

TEST_CASE("no advice names a part of the longest pause that is below a tenth of it") {
  const auto conclusion = [](Duration drawing, Duration step) {
    return size_text(size_segments(play({.visualization = drawing, .step = step, .paced = true}, 90), "", {}));
  };
  // Periods of 33.33 ms, 15 steps. Mostly waiting, half of both, all drawing.
  const std::string waits = conclusion(Duration{2 * ms}, Duration{ms / 10});
  CHECK_THAT(waits,
             Contains("Of the longest pause, 31.8 ms, 2 are drawing, 29.8 are waiting. The steps take 1.5 of 33.33 ms") &&
                 Contains("--spread") && !Contains("shorter visualization"));
  const std::string both = conclusion(Duration{15 * ms}, Duration{ms / 10});
  CHECK_THAT(both, Contains("--spread") && Contains("A shorter visualization helps"));
  const std::string draws = conclusion(Duration{18'333'333}, Duration{ms});
  CHECK_THAT(draws, Contains("Of the longest pause, 18.3 ms, 18.3 are drawing.") && !Contains("--spread") &&
                        Contains("A shorter visualization helps"));
}

TEST_CASE("of forces that travel to the device the bounds judge no map, because they leave the way out") {
  std::vector<SegmentTiming> segments = play({.visualization = {}, .steps = {1}, .step = Duration{1 * ms}}, 90);
  CHECK_THAT(size_text(size_segments(segments, "", {})), Contains("pause bound of") || Contains("The pause bound is "));
  for (SegmentTiming& segment : segments) segment.transports.assign(segment.steps.size(), {Duration{20 * ms}, false});
  const std::string text = size_text(size_segments(segments, "", {}));
  CHECK_THAT(
      text, Contains("they do not judge the map here") && !Contains("the machine") && !Contains("times the pause bound of"));
}

TEST_CASE("the machine is said to set the latency up to 1.25 times the pause bound, and the map above") {
  SizeRecord record = size_segments(play({.visualization = {10 * ms}, .step = Duration{1 * ms}}, 90), "", {});
  record.linear.reset();
  const std::int64_t latency_ns = strategy_to_use(record)->any_phase.latency.ns;
  const auto text_at = [&](std::int64_t hundredths) {
    record.held.pause = Duration{latency_ns * 100 / hundredths};
    return size_text(record);
  };
  CHECK_THAT(text_at(124), Contains("the machine sets the latency") && !Contains("times the pause bound of"));
  CHECK_THAT(text_at(126), Contains("1.26 times the pause bound of") && !Contains("the machine sets the latency"));
}

TEST_CASE("a map that waits for future samples does so in each of its numbers") {
  const ReadResult read = read_scenario(EVENSTEP_SOURCE_DIR "/scenarios/sources/slower.toml");
  REQUIRE(read);
  const SizeRecord record = size_scenario(*read, {.other_maps = true}).record;
  const SizeNeed& line = strategy(record, "linear").any_phase;
  const SizeNeed& fir = strategy(record, "polyphase").any_phase;
  const Duration ahead = fir.latency - line.latency;
  CHECK(ahead > Duration{0});
  CHECK(fir.windows.most - line.windows.most == ahead);
  CHECK(fir.latency - fir.culprit.mended_latency <= fir.culprit.pause_excess + fir.culprit.run_excess);
}

TEST_CASE("of a profiler's file the printed tables have its roles, and are accepted") {
  const TemporaryFolder folder;
  const std::string file = folder / "conclusion.json";
  const auto events = [](const char* name, RealTime begin, RealTime end) {
    return fmt::format(R"({{"name":"{}","ph":"X","pid":1,"tid":1,"ts":{}.{:03},"dur":{}.{:03}}},)", name, begin.ns / 1000,
                       begin.ns % 1000, (end - begin).ns / 1000, (end - begin).ns % 1000);
  };
  std::string json = "[";
  for (const SegmentTiming& segment :
       play({.visualization = {10 * ms}, .step = Duration{1 * ms}, .hitch = Hitch{{1'000 * ms}, {25 * ms}}}, 300)) {
    if (segment.visualization) json += events(R"(draw \"all\")", segment.visualization->begin, segment.visualization->end);
    for (const Interval& step : segment.steps) json += events("solve", step.begin, step.end);
  }
  std::ofstream(file) << json.substr(0, json.size() - 1) << "]";
  const Pasted out = pasted(file, {{"", R"(draw "[a-z]+")", "solve", "", "", 0, {}}, {}});
  CHECK(out.sized.trace_roles == R"({ visualization = "draw \"[a-z]+\"", step = "solve" })");
  CHECK(strategy(out.scenario, "phase_locked").any_phase.latency == strategy(out.sized, "phase_locked").any_phase.latency);
  CHECK(out.run.verdict == RunVerdict::pass);
}

TEST_CASE("the conclusion names map, latency, stiffness and what mending is worth, a list of steps has no [timing] yet") {
  std::vector<SegmentTiming> segments =
      play({.visualization = {10 * ms}, .step = Duration{1 * ms}, .hitch = Hitch{{1'000 * ms}, {25 * ms}}}, 300);
  const SizeRecord record = size_segments(segments, "programmed.csv", {});
  const std::string text = size_text(record);
  CHECK_THAT(text, Contains("Use phase_locked with a latency of ") && Contains("N/m at 1 N s/m") &&
                       Contains("All of that is the 7 visualizations of 25 ms, every "));
  SizeRecord list = record;
  list.segments_from = "cycle";
  CHECK_THAT(size_text(list), Contains("--timing timing.csv"));
  list.trace = "with \"quotes\" and \\.csv";
  CHECK_THAT(size_text(list), Contains("trace = \"with \\\"quotes\\\" and \\\\.csv\""));
  SizeRecord none = record;
  for (SizeStrategy& one : none.strategies) one.any_phase.culprit.step = -1;
  CHECK_THAT(size_text(none), Contains("No map can be named"));
  CHECK(strategy_to_use(none) == nullptr);
}
