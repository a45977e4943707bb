// A recording of a solver, in virtual time. The test chooses how long the steps of the solver take.
#include "evenstep/campaigns/record_solver.h"

#include <sched.h>

#include "catch.h"
#include "evenstep/clock/virtual_clock.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/live_run.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/reports/run_failure.h"
#include "scenarios.h"

using namespace evenstep;
using namespace evenstep::test;
using Catch::Contains;

namespace {

class MadeLog final : public CommandLog {
 public:
  std::size_t size() const override { return commands.size(); }
  std::vector<DeviceCommand> take() override { return std::exchange(commands, {}); }
  std::vector<DeviceCommand> commands;
};

/// Step n takes `lengths_ns[n]`; further steps take as long as the last one.
class TimedSolver final : public Solver {
 public:
  explicit TimedSolver(std::vector<std::int64_t> lengths_ns) : lengths_ns_(std::move(lengths_ns)) {}
  VirtualClock clock;
  std::optional<MadeLog> log;
  std::vector<DeviceCommand> of_each_step, of_reading;
  std::int64_t steps = 0, interrupt_at = -1, fail_at = -1;
  std::atomic<bool> interrupted{false};
  std::vector<glm::dvec3> positions_m;

  ToolResponse step(std::span<const glm::dvec3> tools_m, std::optional<double>) override {
    if (steps == fail_at) throw SolverError(SolverFault::unavailable, "the device is gone", "look for it");
    positions_m.push_back(tools_m.front());
    const auto n = static_cast<std::size_t>(steps++);
    clock.wait_until(clock.now() + Duration{lengths_ns_[std::min(n, lengths_ns_.size() - 1)]});
    if (log) log->commands.insert(log->commands.end(), of_each_step.begin(), of_each_step.end());
    if (steps == interrupt_at) interrupted = true;
    return {};
  }
  std::span<const ToolContact> contacts() const override { return {}; }
  std::uint64_t state_digest() override {
    FAIL("what only checks need is left out");
    return 0;
  }
  void reset() override {}
  ParticleState particle_state() override {
    if (log) log->commands.insert(log->commands.end(), of_reading.begin(), of_reading.end());
    return {};
  }
  SolverVerdict verdict() override { return {}; }
  const SolverInfo& info() const override { return info_; }
  CommandLog* command_log() override { return log ? &*log : nullptr; }

 private:
  std::vector<std::int64_t> lengths_ns_;
  SolverInfo info_;
};

/// 100 segments a second of 2 steps with pauses of 3 ms.
Scenario scenario_with(const std::vector<std::string>& more = {}) {
  std::vector<std::string> set{"timing.segment=\"100 Hz\"", "timing.visualization=\"3 ms\"", "timing.steps=2"};
  set.insert(set.end(), more.begin(), more.end());
  return read("paper/figure-1-spring.toml", set);
}

SolverRecording recorded(TimedSolver& solver, const Scenario& scenario, std::int64_t length_ns = 30'000'000) {
  return record_solver(scenario, solver, solver.clock, {.length = Duration{length_ns}, .interrupted = &solver.interrupted});
}

/// timing.csv without its header.
std::string rows(const SolverRecording& recording) {
  const std::string csv = format_timing_csv(recording.segments);
  return csv.substr(csv.find('\n') + 1);
}

DeviceCommand command(const char* name, std::uint64_t queued, std::uint64_t submitted, std::uint64_t started,
                      std::uint64_t ended) {
  return {name, queued, submitted, started, ended};
}

}  // namespace

TEST_CASE("A recording has the pauses and the rate of the scenario, and steps as long as the solver takes") {
  TimedSolver solver({1'000'000, 2'000'000});
  CHECK(rows(recorded(solver, scenario_with())) ==
        "0,visualization,0,0,3000000\n0,step,0,3000000,4000000\n0,step,1,4000000,6000000\n0,idle,0,6000000,10000000\n"
        "1,visualization,0,10000000,13000000\n1,step,0,13000000,15000000\n1,step,1,15000000,17000000\n"
        "1,idle,0,17000000,20000000\n"
        "2,visualization,0,20000000,23000000\n2,step,0,23000000,25000000\n2,step,1,25000000,27000000\n");
}

TEST_CASE("A visualization that is really run is recorded as long as it takes, and in the place of the pause") {
  struct Drawing final : Visualization {
    explicit Drawing(VirtualClock& moved) : clock(moved) {}
    void begins(Duration length, const DrawingPart&) override { programmed = length; }
    void run() override { clock.wait_until(clock.now() + Duration{1'500'000 + 500'000 * drawn++}); }
    VirtualClock& clock;
    Duration programmed;
    std::int64_t drawn = 0;
  };
  TimedSolver solver({1'000'000});
  Drawing drawing(solver.clock);
  const SolverRecording recording =
      record_solver(scenario_with(), solver, solver.clock, {.length = Duration{20'000'000}, .visualization = &drawing});
  CHECK(rows(recording) ==
        "0,visualization,0,0,1500000\n0,step,0,1500000,2500000\n0,step,1,2500000,3500000\n0,idle,0,3500000,10000000\n"
        "1,visualization,0,10000000,12000000\n1,step,0,12000000,13000000\n1,step,1,13000000,14000000\n");
  CHECK(drawing.programmed == Duration{3'000'000});
  CHECK(summarize(recording).visualization.max == 2'000'000);
}

TEST_CASE("A solver that is too slow for the rate begins its segments late, and none is skipped") {
  TimedSolver solver({5'000'000});
  const SolverRecording recording = recorded(solver, scenario_with());
  CHECK(rows(recording) ==
        "0,visualization,0,0,3000000\n0,step,0,3000000,8000000\n0,step,1,8000000,13000000\n"
        "1,visualization,0,13000000,16000000\n1,step,0,16000000,21000000\n1,step,1,21000000,26000000\n");
  CHECK(recording.late_segments == 2);  // including the third, which the end cut off
  CHECK(recording.latest == Duration{6'000'000});
}

TEST_CASE("Steps that are spread wait for their slots, and one that is late follows at once") {
  // Slots of 5 ms in segments of 10 ms.
  TimedSolver solver({1'000'000, 1'000'000, 6'000'000, 1'000'000, 1'000'000});
  const Scenario scenario = scenario_with({"timing.governor.steps=spread"});
  CHECK(rows(recorded(solver, scenario)) ==
        "0,visualization,0,0,3000000\n0,step,0,3000000,4000000\n"
        "0,step,1,5000000,6000000\n0,idle,0,6000000,10000000\n"
        "1,visualization,0,10000000,13000000\n1,step,0,13000000,19000000\n1,step,1,19000000,20000000\n"
        "2,visualization,0,20000000,23000000\n2,step,0,23000000,24000000\n"
        "2,step,1,25000000,26000000\n");
}

TEST_CASE("Steps come first where the scenario says so, and alone where it draws nothing") {
  TimedSolver first({1'000'000}), alone({1'000'000});
  CHECK(rows(recorded(first, scenario_with({"timing.order=\"steps-first\""}), 5'000'000)) ==
        "0,step,0,0,1000000\n0,step,1,1000000,2000000\n0,visualization,0,2000000,5000000\n");
  CHECK(rows(recorded(alone, scenario_with({"timing.visualization=\"0 s\""}), 5'000'000)) ==
        "0,step,0,0,1000000\n0,step,1,1000000,2000000\n");
}

TEST_CASE("The tools move as the scenario's motions say, at the time at which their step begins") {
  TimedSolver solver({1'000'000});
  const Scenario scenario = scenario_with();
  const SolverRecording recording = recorded(solver, scenario);
  std::size_t n = 0;
  for (const SegmentTiming& segment : recording.segments) {
    for (const Interval& step : segment.steps)
      CHECK(solver.positions_m[n++] == position_m(scenario.devices[0].motion, step.begin));
  }
  CHECK(n == 6);
}

TEST_CASE("An interrupt keeps the whole segments so far, or what there is of the first one") {
  TimedSolver later({1'000'000}), early({1'000'000});
  later.interrupt_at = 3;
  const SolverRecording two = recorded(later, scenario_with());
  CHECK(two.interrupted);
  CHECK(two.segments.size() == 1);
  CHECK(two.segments.front().steps.size() == 2);
  early.interrupt_at = 1;
  const SolverRecording one = recorded(early, scenario_with());
  CHECK(one.segments.size() == 1);
  CHECK(one.segments.front().steps.size() == 1);
}

TEST_CASE("A recording that ends amid a segment leaves it out: its number of steps would be the end's, not the scene's") {
  TimedSolver solver({1'000'000});
  CHECK(recorded(solver, scenario_with(), 14'000'000).segments.size() == 1);
}

TEST_CASE("A step that fails ends the recording with the solver's own words and remedy") {
  TimedSolver solver({1'000'000});
  solver.fail_at = 3;
  try {
    recorded(solver, scenario_with());
    FAIL("not refused");
  } catch (const RunFailure& failure) {
    CHECK_THAT(failure.what(), Contains("the device is gone"));
    CHECK(failure.remedy == "look for it");
  }
}

TEST_CASE("What is recorded reads back as the same timing, and a run can replay it, on 200 random solvers", "[property]") {
  std::uint64_t state = 1;
  const auto draw = [&](std::uint64_t most) {
    state = state * 6364136223846793005ULL + 1;
    return (state >> 33U) % most;
  };
  for (int n = 0; n < 200; ++n) {
    std::vector<std::int64_t> lengths_ns;
    for (int i = 0; i < 20; ++i) lengths_ns.push_back(static_cast<std::int64_t>(draw(6'000'000)));
    TimedSolver solver(lengths_ns);
    const char* const orders[] = {"visualization-first", "steps-first"};
    const SolverRecording recording =
        recorded(solver,
                 scenario_with({std::string("timing.order=\"") + orders[draw(2)] + "\"",
                                "timing.steps=" + std::to_string(1 + draw(4)), "timing.step=\"0.5 ms\""}),
                 static_cast<std::int64_t>(1 + draw(60'000'000)));
    const std::string csv = format_timing_csv(recording.segments);
    const TimingCsv read = parse_timing_csv("# a remark\n" + csv, "x.csv");
    for (const Diagnostic& error : read.error_or({})) UNSCOPED_INFO(text(error));
    REQUIRE(read);
    REQUIRE(format_timing_csv(*read) == csv);
  }
}

TEST_CASE("A [case] and visualizations beside the steps are refused with what to give instead") {
  CHECK(record_objection(scenario_with()).empty());
  CHECK_THAT(record_objection(read("stiff/s1-oscillator.toml")), Contains("[case]"));
  Scenario beside = scenario_with();
  beside.timing.programmed.order = SegmentOrder::concurrent;
  CHECK_THAT(record_objection(beside), Contains("steps-first"));
}

TEST_CASE(
    "The device's times are lengths on a clock of their own: span, busy and waiting of each step, and the host's rest") {
  TimedSolver solver({1'000'000});
  solver.log.emplace();
  solver.log->commands = {command("warm-up", 1, 2, 3, 4)};
  // Two kernels overlap by 100 us, then nothing happens for 200 us, then comes a read: 900 us in all, 600 of them busy.
  const std::uint64_t zero = 1ULL << 62U;
  solver.of_each_step = {command("advance", zero, zero + 10'000, zero + 100'000, zero + 500'000),
                         command("force", zero + 5'000, zero + 20'000, zero + 400'000, zero + 600'000),
                         command("read", zero + 7'000, zero + 30'000, zero + 800'000, zero + 900'000)};
  const SolverRecording recording = recorded(solver, scenario_with());
  CHECK(recording.commands.size() == 3 * 6);
  CHECK(recording.commands.back().segment == 2);
  CHECK(recording.commands.back().step == 1);
  const RecordSummary summary = summarize(recording);
  CHECK(summary.segments == 3);
  CHECK(summary.visualizations == 3);
  CHECK(summary.steps == 6);
  CHECK(summary.steps_on_device == 6);
  CHECK(summary.host.p50 == 1'000'000);
  CHECK(summary.span.p99 == 900'000);
  CHECK(summary.busy.max == 600'000);
  CHECK(summary.waiting.p50 == 300'000);
  CHECK(summary.beyond.p50 == 100'000);
  REQUIRE(summary.commands.size() == 3);
  CHECK(summary.commands[1].name == "force");
  CHECK(summary.commands[1].count == 6);
  CHECK(summary.commands[1].waits_queued_ns == 15'000);
  CHECK(summary.commands[1].waits_submitted_ns == 380'000);
  CHECK(summary.commands[1].runs_ns == 200'000);
  CHECK_THAT(commands_csv(recording),
             Catch::StartsWith("segment,kind,index,name,queued_ns,submitted_ns,started_ns,ended_ns\n"
                               "0,step,0,advance,0,10000,100000,500000\n"
                               "0,step,0,force,5000,20000,400000,600000\n"));
  CHECK_THAT(record_table(summary, recording),
             Contains("host - device") && Contains("advance") && !Contains("visualization: ") && !Contains("trusted"));
}

TEST_CASE("What a drawing reads from the device belongs to the drawing, and not to the step after it") {
  struct ReadingDrawing final : Visualization {
    explicit ReadingDrawing(TimedSolver& read) : solver(read) {}
    void begins(Duration, const DrawingPart&) override {}
    void run() override {
      solver.particle_state();
      solver.clock.wait_until(solver.clock.now() + Duration{2'000'000});
    }
    TimedSolver& solver;
  };
  TimedSolver solver({1'000'000});
  solver.log.emplace();
  solver.of_reading = {command("read", 1'000'000, 1'010'000, 1'020'000, 1'050'000),
                       command("read", 1'050'000, 1'060'000, 1'070'000, 1'100'000)};
  solver.of_each_step = {command("advance", 3'000'000, 3'010'000, 3'020'000, 3'500'000),
                         command("read", 3'500'000, 3'510'000, 3'520'000, 3'900'000)};
  ReadingDrawing drawing(solver);
  const SolverRecording recording =
      record_solver(scenario_with(), solver, solver.clock, {.length = Duration{30'000'000}, .visualization = &drawing});
  const RecordSummary summary = summarize(recording);
  CHECK(summary.steps_on_device == 6);
  CHECK(summary.span.max == 900'000);  // counted into the first step, the drawing's commands would make it 2.9 ms
  CHECK(summary.beyond.p50 == 100'000);
  CHECK(summary.steps_beyond_host == 0);
  REQUIRE(summary.commands.size() == 2);
  CHECK(summary.commands[1].name == "read");
  CHECK(summary.commands[1].count == 6);
  REQUIRE(summary.drawing_commands.size() == 1);
  CHECK(summary.drawing_commands[0].count == 2 * 3);
  CHECK(summary.drawing_span.max == 100'000);
  CHECK(summary.drawing_busy.max == 60'000);
  CHECK_THAT(commands_csv(recording),
             Contains("\n0,visualization,0,read,50000,60000,70000,100000\n0,step,0,advance,2000000,"));
  CHECK_THAT(record_table(summary, recording), Contains("visualization: read") && !Contains("trusted"));
}

TEST_CASE("A step that is longer on the device than on the host is said: one of the two times is wrong") {
  TimedSolver solver({1'000'000});
  solver.log.emplace();
  solver.of_each_step = {command("advance", 1'000'000, 1'010'000, 1'020'000, 2'250'000)};
  const SolverRecording recording = recorded(solver, scenario_with());
  const RecordSummary summary = summarize(recording);
  CHECK(summary.steps_beyond_host == 6);
  CHECK(summary.beyond_host_max_ns == 250'000);
  CHECK_THAT(record_table(summary, recording),
             Contains("not to be trusted: 6 of 6 steps took longer on the device") && Contains("up to 0.2500 ms more"));
}

TEST_CASE("Commands whose times are missing or not in order are left out and counted, whatever the driver says") {
  TimedSolver solver({1'000'000});
  solver.log.emplace();
  solver.of_each_step = {command("none", 0, 0, 0, 0), command("back", 10, 9, 11, 12), command("late", 5, 6, 8, 7),
                         command("far", 1, 2, 3, UINT64_MAX), command("good", 10, 20, 30, INT64_MAX)};
  const SolverRecording recording = recorded(solver, scenario_with());
  const RecordSummary summary = summarize(recording);
  CHECK(summary.commands_without_times == 4 * 6);
  CHECK(summary.commands.size() == 1);
  CHECK(summary.span.max == INT64_MAX - 10);
  CHECK_THAT(record_table(summary, recording), Contains("left out: 24 commands"));
}

TEST_CASE("The device's clock is compared with the host's over the recording, from a second on") {
  SolverRecording recording;
  SegmentTiming segment;
  for (std::int64_t n = 0; n < 3; ++n) {
    segment.steps.push_back({{n * 1'000'000'000}, {n * 1'000'000'000 + 1000}});
    const std::uint64_t at = 7 + static_cast<std::uint64_t>(n) * 1'000'100'000;
    recording.commands.push_back({0, static_cast<std::size_t>(n), command("k", at, at, at, at + 500)});
  }
  segment.end = segment.steps.back().end;
  recording.segments.push_back(segment);
  CHECK(summarize(recording).faster_ppm == Approx(100));
}

TEST_CASE("Without a device the table has host times alone, and no file of commands has rows") {
  TimedSolver solver({1'000'000, 2'000'000, 4'000'000});
  const SolverRecording recording = recorded(solver, scenario_with());
  const RecordSummary summary = summarize(recording);
  CHECK(summary.steps_on_device == 0);
  CHECK(summary.host.p50 == 4'000'000);
  CHECK_THAT(record_table(summary, recording), !Contains("device"));
  CHECK(commands_csv(recording) == "segment,kind,index,name,queued_ns,submitted_ns,started_ns,ended_ns\n");
}

TEST_CASE("The head of a recording names device, driver, host, load, clock and date, a line each, whatever they contain") {
  RecordHead head{"evenstep record a.toml --seconds 1", "2026-11-23T11:20:00Z", {}};
  head.machine.processor = "cpu\n0,step,0,0,1";
  head.machine.device = {"gpu\x1b[31m", "platform", "OpenCL 3.0", "550.54", 108, 1410, 1000};
  head.machine.host_clock = "tsc";
  head.machine.load_before = 0.5;
  SolverRecording recording;
  recording.commands.push_back({});
  const std::string text = head_text(head, scenario_with(), SolverInfo{"opencl"}, recording);
  for (const char* const part :
       {"evenstep record a.toml --seconds 1", "2026-11-23T11:20:00Z", "gpu [31m", "550.54", "platform", "108 compute units",
        "1410 MHz", "0.50 before", "CLOCK_MONOTONIC (tsc)", "1000 ns"})
    CHECK_THAT(text, Contains(part));
  CHECK(parse_timing_csv(text + "segment,kind,index,begin_ns,end_ns\n0,step,0,0,1\n", "x.csv"));
}

TEST_CASE("On this machine's clock and OpenCL a recording has the scene's steps, one after the other, and their commands") {
  std::vector<std::string> set = small_tissue("opencl");
  set.push_back("timing.segment=\"50 Hz\"");
  set.push_back("timing.visualization=\"2 ms\"");
  set.push_back("timing.steps=3");
  const Scenario scenario = read("paper/figure-1.toml", set);
  const auto solver = make_recorded_solver(scenario, true);
  WallClock clock(WallEpoch::in(Duration{10'000'000}));
  const int policy_before = sched_getscheduler(0);
  const SolverRecording recording = record_solver(scenario, *solver, clock, {.length = Duration{200'000'000}});
  REQUIRE(recording.rights);
  CHECK(recording.rights->priority == kSolverPriority);
  CHECK(recording.rights->fifo == recording.rights->refusal.empty());
  CHECK(sched_getscheduler(0) == policy_before);  // they are given back
  REQUIRE_FALSE(recording.segments.empty());
  std::size_t steps = 0, of_step = 0;
  for (const SegmentTiming& segment : recording.segments) {
    CHECK((segment.steps.size() == 3 || recording.segments.size() == 1));
    steps += segment.steps.size();
  }
  CHECK(parse_timing_csv(format_timing_csv(recording.segments), "x.csv"));
  const RecordSummary summary = summarize(recording);
  CHECK(summary.commands_without_times == 0);
  CHECK(summary.steps_on_device == static_cast<std::int64_t>(steps));
  CHECK(summary.steps_beyond_host == 0);
  for (const RecordedCommand& one : recording.commands) of_step += one.segment == 0 && one.step == 0;
  CHECK(recording.commands.size() == steps * of_step);
}
