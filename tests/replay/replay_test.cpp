// A live run, its recording, and the replay of it. Nothing here asserts how late a machine is. On any machine the replay
// must be the run, bit for bit, also that of a run that was killed.

#include <unistd.h>

#include <fmt/format.h>
#include <sys/wait.h>
#include <csignal>
#include <cstring>
#include <set>
#include <thread>

#include "evenstep/harness/live_run.h"
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/harness/run.h"
#include "evenstep/recordings/timing_csv.h"
#include "recordings.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

std::vector<std::string> live(std::vector<std::string> more, const std::string& duration = "0.5 s") {
  more.insert(more.end(), {"remap.latency=\"60 ms\"", "remap.lead=\"20 ms\"", "run.duration=\"" + duration + "\"",
                           "expect=[]", "run.strategies=[\"direct\", \"phase_locked\"]", "run.warmup=\"0 s\""});
  return more;
}

RunOutcome record(const Scenario& scenario, const std::string& path) {
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.record_to = path;
  return run_scenario(scenario, options);
}

RunOutcome replay_log(const InputLog& log, const Scenario& scenario) {
  RunOptions options;
  options.clock = ClockKind::wall;
  options.allow_no_expectations = true;
  options.replayed = &log;
  return run_scenario(scenario, options);
}

RunOutcome replay_file(const std::string& path) {
  const InputLogResult log = read_input_log(path);
  INFO(errors_of(log));
  REQUIRE(log);
  const ReadResult scenario = scenario_of(*log);
  for (const Diagnostic& error : scenario.error_or({})) UNSCOPED_INFO(text(error));
  REQUIRE(scenario);
  return replay_log(*log, *scenario);
}

/// The first difference between the metrics of two runs, apart from times of the machine.
std::string first_difference_of(const Metrics& a, const Metrics& b) {
  for (const auto& [signal, values] : a) {
    for (const auto& [metric, value] : values) {
      if (metric == "solver_seconds") continue;
      const auto there = b.find(signal);
      if (there == b.end() || !there->second.contains(metric)) return signal + " has no " + metric;
      const double again = there->second.at(metric);
      if (std::memcmp(&value, &again, sizeof value) != 0 && !(std::isnan(value) && std::isnan(again)))
        return fmt::format("{} {}: {} and {}", signal, metric, value, again);
    }
  }
  return a.size() == b.size() ? "" : "more signals";
}

}  // namespace

TEST_CASE("a replay from the file has the hash, the forces and every metric of the live run, whatever the device is",
          "[sweep]") {
  const std::string motion =
      "device.left.motion={ kind = \"sine\", amplitude = [\"10 mm\", \"5 mm\", \"0 mm\"], frequency = "
      "\"3 Hz\" }";
  struct Case {
    const char *name, *scenario;
    std::vector<std::string> set;
  };
  std::vector<std::string> two_devices = small_tissue("cpu");
  std::erase_if(two_devices, [](const std::string& set) { return set.starts_with("run.duration"); });
  std::vector<std::string> burning = two_devices;
  burning.push_back("timing.visualization=\"burn 11.1 ms\"");
  std::vector<std::string> capped;
  for (const char* hand : {"left", "right"})
    capped.push_back(
        fmt::format("device.{}.render={{ kind = \"local\", stiffness = \"settled\", coupled = true, cap = \"100 "
                    "N/m\" }}",
                    hand));
  const std::vector<Case> cases{
      {"reference", "paper/figure-1-spring.toml", {motion}},
      {"two devices and a tissue", "paper/figure-1.toml", two_devices},
      {"PID",
       "paper/figure-1-spring.toml",
       {motion, "device.left.driver=\"pid\"",
        "device.left.pid={ travel = [\"400 mm\", \"400 mm\", \"0 mm\"], full_scale = \"100 N\", gain = 1.0 }"}},
      {"springs of a PID device",
       "paper/figure-1-spring.toml",
       {motion, "device.left.driver=\"pid\"",
        "device.left.pid={ travel = [\"400 mm\", \"400 mm\", \"0 mm\"], full_scale = \"100 N\", gain = 1.0, springs = "
        "[\"x\", \"y\"], flavour = \"mask\", full_slope = \"500 N/m\" }",
        "device.left.render={ kind = \"device_spring\" }"}},
      {"evdev",
       "paper/figure-1-spring.toml",
       {motion, "device.left.driver=\"evdev\"",
        "device.left.evdev={ travel = [\"0.6 m\", \"0.6 m\", \"0 m\"], full_scale = \"100 N\", gain = 1.0 }"}},
      {"events that say when",
       "paper/figure-1-spring.toml",
       {motion, "device.left.driver=\"evdev\"", "device.left.sample_time=\"taken\"", "device.left.report_age=\"0.4 ms\"",
        "device.left.report_age_jitter=\"0.3 ms\"",
        "device.left.evdev={ travel = [\"0.6 m\", \"0.6 m\", \"0 m\"], full_scale = \"100 N\", gain = 1.0 }"}},
      {"a device's own clock",
       "paper/figure-1-spring.toml",
       {motion, "device.left.sample_time=\"taken\"", "device.left.report_age=\"0.4 ms\"",
        "device.left.report_age_jitter=\"0.3 ms\""}},
      {"inverse3",
       "paper/figure-1-spring.toml",
       {motion, "device.left.driver=\"inverse3\"", "device.left.inverse3={ origin = [\"0 m\", \"0 m\", \"0 m\"] }"}},
      {"visualizations that burn", "paper/figure-1.toml", burning},
      {"two hands with their coupling, OpenCL", "closed-loop/hands-near-coupled.toml", {"scene.solver=\"opencl\""}},
      {"the same under one cap, CPU", "closed-loop/hands-near-coupled.toml", capped},
      {"adaptive, steps as fast as they come",
       "paper/figure-1-spring.toml",
       {motion, "timing.step=\"real\"", "remap.adapt={ window = \"0.1 s\" }"}}};
  const TemporaryFolder folder;
  for (const Case& one : cases) {
    const std::string path = folder / one.name;
    const RunOutcome live_run = record(read(one.scenario, live(one.set)), path);
    INFO(one.name << ": " << live_run.failure << live_run.repeat_difference);
    for (const Diagnostic& error : live_run.errors) UNSCOPED_INFO(text(error));
    REQUIRE(live_run.exit == ExitCode::pass);
    const RunOutcome again = replay_file(path);
    INFO(again.failure << again.repeat_difference);
    CHECK(again.exit == ExitCode::pass);
    CHECK(again.record.trace_hash == live_run.record.trace_hash);
    CHECK(digest_of_forces(strategy(again.record, "phase_locked")) ==
          digest_of_forces(strategy(live_run.record, "phase_locked")));
    CHECK(first_difference_of(live_run.metrics, again.metrics) == "");
    CHECK(strategy(again.record, "phase_locked").devices[0].ticks.size() > 300);
  }
}

namespace {

void cut_anywhere(const Scenario& recorded) {
  const TemporaryFolder folder;
  const RunOutcome whole = record(recorded, folder / "x");
  REQUIRE(whole.exit == ExitCode::pass);
  const Bytes bytes = bytes_of(folder / "x");
  const InputLogResult log = read_input_log(folder / "x");
  REQUIRE(log);
  const ReadResult scenario = scenario_of(*log);
  REQUIRE(scenario);
  std::set<std::int64_t> lengths;
  for (std::size_t length = 1; length < bytes.size(); length += 97) {
    const InputLogResult cut = parse_input_log(std::span(bytes).first(length), "x");
    if (!cut || !lengths.insert(cut->bytes).second) continue;
    const RunOutcome outcome = replay_log(*cut, *scenario);
    INFO(length << " of " << bytes.size() << " bytes, " << cut->blocks << " blocks: " << outcome.failure
                << outcome.repeat_difference);
    REQUIRE(outcome.results.empty());
    if (cut->until() == RealTime{0}) {
      REQUIRE(outcome.exit == ExitCode::run_failed);
      continue;
    }
    REQUIRE(outcome.exit == ExitCode::pass);
    // A lane that was late needs what the other lane did after this slice.
    REQUIRE(outcome.record.nominal.end <= cut->until());
    REQUIRE(outcome.record.nominal.end + Duration{200'000'000} >= cut->until());
    // The recording of the device lane may be longer: those ticks were due, too.
    REQUIRE(outcome.metrics.at("events.device.tick").at("deadline_misses") >= 0);
  }
  CHECK(lengths.size() > 15);
}

}  // namespace

TEST_CASE("a recording that is cut at any block replays, as far as it goes, to what was recorded") {
  cut_anywhere(read("paper/figure-1-spring.toml", live({})));
}

TEST_CASE("a recording that is cut in a visualization that burns replays, as far as it goes, to what was recorded",
          "[sweep]") {
  std::vector<std::string> set = small_tissue("cpu");
  std::erase_if(set, [](const std::string& one) { return one.starts_with("run.duration"); });
  for (const char* one : {"timing.visualization=\"burn 25 ms\"", "timing.segment=\"20 Hz\"", "timing.steps=5"})
    set.push_back(one);
  cut_anywhere(read("paper/figure-1.toml", live(set)));
}

TEST_CASE("a recording whose contents were changed under right checksums replays to some end, or is refused") {
  const TemporaryFolder folder;
  REQUIRE(record(read("paper/figure-1-spring.toml", live({}, "0.1 s")), folder / "x").exit == ExitCode::pass);
  const Bytes bytes = bytes_of(folder / "x");
  const InputLogResult log = read_input_log(folder / "x");
  REQUIRE(log);
  const ReadResult scenario = scenario_of(*log);
  REQUIRE(scenario);
  std::uint64_t state = 5;
  int replayed = 0;
  for (int round = 0; round < 150; ++round) {
    Bytes changed = internal::file_begin();
    std::uint64_t sequence = 0;
    for (std::size_t at = changed.size(); at < bytes.size();) {
      internal::BlockHeader header;
      std::memcpy(&header, bytes.data() + at, sizeof header);
      at += sizeof header;
      Bytes content(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                    bytes.begin() + static_cast<std::ptrdiff_t>(at + header.length));
      at += header.length;
      state = spread(state + 1);
      if (sequence > 0 && state % 4 == 0) content[state / 4 % content.size()] = static_cast<std::byte>(state >> 50);
      append(changed, internal::block_bytes(header.kind, sequence++, content));
    }
    const InputLogResult read = parse_input_log(changed, "x");
    if (!read) continue;
    ++replayed;
    const RunOutcome outcome = replay_log(*read, *scenario);
    REQUIRE(outcome.exit != ExitCode::usage);
  }
  CHECK(replayed > 20);
}

TEST_CASE("a replay that is not the run exits with 4 and says where it differs") {
  const TemporaryFolder folder;
  REQUIRE(record(read("paper/figure-1-spring.toml", live({})), folder / "x").exit == ExitCode::pass);
  const InputLogResult read_log = read_input_log(folder / "x");
  REQUIRE(read_log);
  const ReadResult scenario = scenario_of(*read_log);
  REQUIRE(scenario);
  const auto difference_with = [&](const auto& change) {
    InputLog log = *read_log;
    change(log);
    const RunOutcome outcome = replay_log(log, *scenario);
    CHECK(outcome.exit == ExitCode::not_reproducible);
    return outcome.repeat_difference;
  };
  // A machine that was busy has left out ticks before this one.
  CHECK_THAT(difference_with([](InputLog& log) { log.ticks[0][250].force_N.y = 1; }),
             Catch::StartsWith("tick 250 of left, at 0."));
  CHECK_THAT(difference_with([](InputLog& log) { log.device_checks[3].hash ^= 1; }),
             Catch::Contains("the device lane differs between 0.06 s and 0.08 s"));
  CHECK_THAT(difference_with([](InputLog& log) { log.end->trace_hash ^= 1; }), Catch::Contains("was recorded"));
  CHECK_THAT(difference_with([](InputLog& log) { log.inputs[0].ticks[100].sample.position_m.x += 1e-9; }),
             Catch::Contains("tick"));
}

TEST_CASE("a replay counts the steps that never began in the live run, and none where the recording does not say") {
  const TemporaryFolder folder;
  REQUIRE(record(read("paper/figure-1-spring.toml", live({})), folder / "x").exit == ExitCode::pass);
  InputLogResult log = read_input_log(folder / "x");
  REQUIRE(log);
  const ReadResult scenario = scenario_of(*log);
  REQUIRE(scenario);
  const auto not_begun = [&]() -> std::optional<double> {
    const Metrics metrics = replay_log(*log, *scenario).metrics;
    const auto& solver = metrics.at("solver.phase_locked");
    const auto found = solver.find("steps_not_begun");
    return found == solver.end() ? std::nullopt : std::optional(found->second);
  };
  const std::optional<double> as_it_was = not_begun();
  REQUIRE(as_it_was);
  REQUIRE(log->end->steps_due);
  *log->end->steps_due += 7;
  CHECK(not_begun() == *as_it_was + 7);
  log->end->steps_due.reset();
  CHECK_FALSE(not_begun());
}

TEST_CASE("how long the segments of a recording took is a trace that a scenario takes") {
  const TemporaryFolder folder;
  REQUIRE(record(read("paper/figure-1-spring.toml", live({})), folder / "x").exit == ExitCode::pass);
  const InputLogResult log = read_input_log(folder / "x");
  REQUIRE(log);
  const std::vector<SegmentTiming> segments = recorded_timing(log->rows);
  std::ofstream(folder / "timing.csv") << format_timing_csv(segments);
  const TimingCsv again = read_timing_csv(folder / "timing.csv");
  REQUIRE(again);
  CHECK(again->size() == segments.size());
  const Scenario replayed = read("paper/figure-1-spring.toml",
                                 {"timing={ trace = \"" + (folder / "timing.csv") + "\" }", "expect=[]",
                                  "run.duration=\"0.4 s\"", "run.warmup=\"0 s\"", "run.strategies=[\"phase_locked\"]"});
  const RunRecord run = run_all(replayed);
  const Rows<StepRow>& steps = strategy(run, "phase_locked").steps;
  REQUIRE(steps.size() > 100);
  const Duration shift = log->rows.steps[0].begin - steps[0].begin;
  std::int64_t different = 0;
  for (std::size_t n = 0; n < std::min(steps.size(), log->rows.steps.size()); ++n)
    different += steps[n].begin + shift != log->rows.steps[n].begin || steps[n].end + shift != log->rows.steps[n].end;
  CHECK(different == 0);
}

namespace {

void kill_runs(int times, std::uint64_t seed) {
  const TemporaryFolder folder;
  const Scenario scenario = read("paper/figure-1-spring.toml", live({}, "30 s"));
  std::uint64_t state = seed;
  for (int i = 0; i < times; ++i) {
    const std::string path = folder / ("killed-" + std::to_string(i));
    const pid_t child = ::fork();
    if (child == 0) {
      record(scenario, path);
      ::_exit(0);
    }
    // The kill comes at any time from before the file exists to some slices into the run.
    state = spread(state + 1);
    std::this_thread::sleep_for(std::chrono::microseconds(200'000 + state % 400'000));
    std::error_code none;
    const auto kernel_has = std::filesystem::file_size(path, none);
    ::kill(child, SIGKILL);
    int status = 0;
    ::waitpid(child, &status, 0);
    REQUIRE((WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL));
    if (none) continue;
    const InputLogResult log = read_input_log(path);
    INFO("kill " << i << " after " << kernel_has << " bytes: " << errors_of(log));
    REQUIRE(log);
    CHECK_FALSE(log->end);
    REQUIRE(log->bytes + log->left_bytes >= static_cast<std::int64_t>(kernel_has));
    REQUIRE(log->left_bytes < 10'000);  // at most the block that was being written
    if (log->until() == RealTime{0}) continue;
    const RunOutcome outcome = replay_file(path);
    INFO(outcome.failure << outcome.repeat_difference);
    REQUIRE(outcome.exit == ExitCode::pass);
    std::filesystem::remove(path);
  }
}

}  // namespace

TEST_CASE("a run that is killed at 4 random instants replays up to there") { kill_runs(4, 3); }
TEST_CASE("a run that is killed at 200 random instants replays up to there", "[million]") { kill_runs(200, 4); }
