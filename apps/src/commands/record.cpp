#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <filesystem>

#include "evenstep/apps/origin.h"
#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/record_solver.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/visualization.h"
#include "evenstep/recordings/timing_csv.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/text/text_file.h"
#include "src/commands.h"
#include "src/opencl_lines.h"
#include "src/progress.h"

namespace evenstep::app {
namespace {

struct RecordArguments {
  std::string program, file, out;
  int seconds = 20;
  bool host_only = false, spread = false, ordinary = false;
  std::optional<std::uint64_t> seed;
  std::vector<std::string> set;
  std::string visualization;
};

/// Long enough for everything to be ready before t = 0.
constexpr Duration kStartDelay{100'000'000};

std::string typed(const RecordArguments& arguments) {
  std::string command =
      fmt::format("evenstep record {} --seconds {}", shell_file(internal::portable_path(arguments.file)), arguments.seconds);
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  if (!arguments.visualization.empty()) command += " --visualization " + shell_word(arguments.visualization);
  if (arguments.spread) command += " --spread";
  if (arguments.ordinary) command += " --ordinary";
  if (arguments.seed) command += fmt::format(" --seed {}", *arguments.seed);
  return command + (arguments.host_only ? " --host-only" : "");
}

/// "timing.csv" -> "timing.profile.csv"
std::string profile_path(const std::string& out) {
  return std::filesystem::path(out).replace_extension(".profile.csv").string();
}

/// Prints the error, if there is one.
bool write(const std::string& path, const std::string& text) {
  const std::string error = internal::write_text_file(path, text);
  if (!error.empty())
    print({{path, 0, 0, error}});
  else
    fmt::print("wrote {}\n", path);
  return error.empty();
}

/// "timing.csv" -> "timing.drawing.png"
std::string drawing_path(const std::string& out) {
  return std::filesystem::path(out).replace_extension(".drawing.png").string();
}

SolverRecording record_now(const Scenario& scenario, Solver& solver, Visualization* visualization,
                           const RecordArguments& arguments, const std::atomic<bool>& interrupted) {
  Progress progress(isatty(STDERR_FILENO));
  WallClock clock(WallEpoch::in(kStartDelay));
  return record_solver(scenario, solver, clock,
                       {.length = Duration{arguments.seconds * std::int64_t{1'000'000'000}},
                        .interrupted = &interrupted,
                        .progress = [&](double fraction) { progress.update("record", fraction); },
                        .visualization = visualization,
                        .ordinary = arguments.ordinary});
}

/// False after an error, which is then printed.
bool write_files(const RecordArguments& arguments, const std::string& head, const SolverRecording& recording,
                 const std::string& drawing) {
  if (!drawing.empty() && !write(drawing_path(arguments.out), drawing)) return false;
  if (!recording.commands.empty() && !write(profile_path(arguments.out), head + commands_csv(recording))) return false;
  return write(arguments.out, head + format_timing_csv(recording.segments));
}

/// Why a solver does not report its commands; empty if it does.
std::string host_only_text(const RecordArguments& arguments, Solver& solver) {
  if (solver.command_log()) return {};
  if (arguments.host_only) return "host times only: --host-only\n";
  return fmt::format("host times only: the solver '{}' gives no commands to an OpenCL device\n", solver.info().name);
}

ExitCode record_read(const RecordArguments& arguments, const Scenario& scenario, const std::atomic<bool>& interrupted) {
  RecordHead head{typed(arguments), utc_text(unix_seconds()), machine_here()};
  const double started_s = monotonic_seconds();
  auto solver =
      std::make_unique<WatchedSolver>(make_recorded_solver(scenario, !arguments.host_only), scenario.scene.tool_count);
  const std::unique_ptr<RealVisualization> visualization = make_visualization(scenario, *solver);
  if (visualization) head.visualization = visualization->text();
  head.machine.warm_up_s = monotonic_seconds() - started_s;
  if (!solver->info().device.empty()) head.machine.device = describe_opencl(scenario.solver_options);
  fmt::print("recording {} for {} s; Ctrl-C ends it earlier and keeps what was recorded until then\n{}", scenario.file,
             arguments.seconds, host_only_text(arguments, *solver));
  if (const std::string device = opencl_line(scenario); !device.empty()) fmt::print("OpenCL: {}\n", device);
  warn_of_idle_gpu(scenario);
  std::fflush(stdout);
  const SolverRecording recording = record_now(scenario, *solver, visualization.get(), arguments, interrupted);
  head.machine.load_after = load_now();
  const RecordSummary summary = summarize(recording);
  if (summary.steps == 0) {
    spdlog::error("error: no step was recorded, so nothing is written");
    return recording.interrupted ? ExitCode::interrupted : ExitCode::run_failed;
  }
  const std::string head_lines = head_text(head, scenario, solver->info(), recording);
  fmt::print("{}\n{}", head_lines, record_table(summary, recording));
  Pace pace{.step_s = period_s(scenario.scene.step_rate)};
  for (const SegmentTiming& one : recording.segments) pace.add_segment({one.begin, one.end}, one.steps);
  if (const std::string text = is_memoryless(scenario.scene) ? "" : evenstep::text(pace); !text.empty())
    fmt::print("went wrong   {}\n", text);  // as of a live run
  if (!write_files(arguments, head_lines, recording, visualization ? visualization->png() : "")) return ExitCode::run_failed;
  fmt::print("next: {} size {}; in a scenario: [timing] trace = \"{}\"\n", arguments.program, shell_file(arguments.out),
             arguments.out);
  return recording.interrupted ? ExitCode::interrupted : ExitCode::pass;
}

ExitCode record(const RecordArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  const std::string file = here_or_installed(arguments.file);
  std::vector<std::string> set = arguments.set;
  if (!arguments.visualization.empty()) set.push_back("timing.visualization=" + arguments.visualization);
  if (arguments.spread) set.push_back("timing.governor.steps=spread");
  const ReadResult read = read_scenario(file, {set, arguments.seed, registry, true});
  if (!read) {
    print(read.error());
    return ExitCode::usage;
  }
  Scenario scenario = *read;
  scenario.solver_options.prefer_gpu = true;  // it is about this machine's device
  if (const std::string objection = record_objection(scenario); !objection.empty()) {
    print({{file, 0, 0, objection}});
    return ExitCode::usage;
  }
  if (const std::vector<Diagnostic> missing = missing_in_build(scenario, ClockKind::wall); !missing.empty()) {
    print(missing);
    return ExitCode::usage;
  }
  for (const std::string& path : {arguments.out, profile_path(arguments.out)}) {
    const std::string objection = internal::write_objection(path);
    if (objection.empty()) continue;
    print({{path, 0, 0, objection}});
    return ExitCode::run_failed;
  }
  try {
    return record_read(arguments, scenario, interrupted);
  } catch (const RunFailure& failure) {
    spdlog::error("error: {}; nothing was written\nremedy: {}", failure.what(), failure.remedy);
    return ExitCode::run_failed;
  }
}

}  // namespace

void add_record(Commands& commands) {
  auto [command, arguments] = commands.add<RecordArguments>(
      "record", "how long the steps of a scene's real solver take on this machine's device, as timing.csv", record);
  arguments.program = commands.program();
  command.operand("scenario", arguments.file,
                  "its scene and solver are run, with the pauses of its [timing], without a hand");
  command.required_option("--out,-o", arguments.out,
                          "the timing.csv to write; the device's own times go beside it, into timing.profile.csv");
  command.option("--seconds", arguments.seconds, Range{1, 3600}, "how long (default: 20)");
  command.flag("--host-only", arguments.host_only, "without OpenCL's profiling events, which cost a little time themselves");
  command.option("--visualization", arguments.visualization,
                 "instead of the scenario's: render (the tissue is drawn), \"burn 11.1 ms\" (the device is kept busy), or a "
                 "pause of so long");
  command.flag("--spread", arguments.spread, "steps wait for their slots instead of following each other in a burst");
  command.flag("--ordinary", arguments.ordinary,
               "without the real-time rights of a live run, as a program that asks for none");
  command.option("--seed", arguments.seed, "of the scenario's timing");
  command.repeated("--set", arguments.set, "path=value, overrides the file");
}

}  // namespace evenstep::app
