#include <fmt/format.h>
#include <fmt/ranges.h>  // fmt::join, since fmt 11
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>

#include "evenstep/apps/origin.h"
#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/size.h"
#include "evenstep/campaigns/sweep.h"
#include "evenstep/clock/wall_clock.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/suffered.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/saturation.h"
#include "evenstep/reports/trace_json.h"
#include "evenstep/reports/writers.h"
#include "evenstep/time/build_option.h"
#include "src/commands.h"
#include "src/live/watcher.h"
#include "src/opencl_lines.h"
#include "src/output.h"
#include "src/progress.h"
#include "src/run_annotations.h"
#include "src/run_places.h"
#include "src/run_printing.h"

namespace evenstep::app {
namespace fs = std::filesystem;
namespace {

struct RunArguments {
  std::string program;
  std::vector<std::string> paths;
  std::string clock = "virtual";
  std::optional<std::uint64_t> seed;
  std::vector<std::string> set;
  std::string out, junit, record;
  bool trace_json = false;
  bool verbose = false;
  bool repeat = false;
  std::optional<std::uint64_t> permute_ties;
  int threads = 0;
  bool json = false;
  std::vector<std::string> devices;  ///< NAME=PATH or PATH
  bool forces = false;
  bool scope = false, cores_may_sleep = false;
  std::optional<std::int64_t> scope_port;
  bool allow_no_expectations = false, allow_degraded = false;
  bool include_long = false;  ///< also run scenarios with the tag "long" that are found in a folder
};

/// The command that runs this again, into the same folder if that was named. What changes neither the run nor its verdict
/// is left out: what it prints, and other files that it writes, such as a recording, which would be overwritten.
std::string reproduce_command(const RunArguments& arguments, const Scenario& scenario, const std::string& folder) {
  std::string command = fmt::format("{} run {} --seed {}", arguments.program, shell_file(scenario.file), scenario.seed);
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  if (arguments.clock != "virtual") command += " --clock " + arguments.clock;
  for (const std::string& device : arguments.devices) command += " --device " + shell_word(device);
  if (arguments.forces) command += " --forces";
  if (arguments.cores_may_sleep) command += " --cores-may-sleep";
  if (arguments.permute_ties) command += fmt::format(" --permute-ties {}", *arguments.permute_ties);
  if (arguments.repeat) command += " --repeat";
  if (!arguments.out.empty()) command += " --out " + shell_word(folder);
  if (arguments.allow_no_expectations) command += " --allow-no-expectations";
  if (arguments.allow_degraded) command += " --allow-degraded";
  return command;
}

/// What --repeat and --permute-ties have looked at, which otherwise says nothing where all is well.
std::string compared_lines(const RunOutcome& outcome) {
  std::string lines;
  if (outcome.repeated && outcome.repeat_difference.empty())
    lines += fmt::format("repeated: 2 runs, both with the trace {:016x}\n", outcome.record.trace_hash);
  if (outcome.ties)
    lines += fmt::format(
        "permuted: 1 run, its simultaneous events in the order of seed {}; judged as any run, compared with no other\n",
        *outcome.ties);
  return lines;
}

void print_case(const CaseRecord& record, const RunOutcome& outcome, const std::string& folder) {
  std::size_t cells = 0;
  for (const CaseRow& row : record.rows) cells += row.cells.size();
  fmt::print("{}", case_table(record));
  fmt::print("trace {:016x}   {} cells, each on two schedules, in {:.2f} s CPU\n", outcome.record.trace_hash, cells,
             outcome.cpu_seconds);
  fmt::print("{}", compared_lines(outcome));
  fmt::print("figures and data in {}\n", folder);
}

/// "4 s", or "2.1 of 4 s" for a run that was interrupted or failed.
std::string simulated_text(const Scenario& scenario, const RunOutcome& outcome) {
  RealTime reached{0};
  bool whole = outcome.failure.empty();
  for (const StrategyRecord& strategy : outcome.record.strategies) {
    whole = whole && !strategy.interrupted;
    for (const DeviceRecord& device : strategy.devices) {
      if (!device.ticks.empty()) reached = std::max(reached, device.ticks.back().at);
    }
  }
  const double all_s = seconds(scenario.run_duration);
  return whole ? fmt::format("{:.3g} s", all_s) : fmt::format("{:.3g} of {:.3g} s", seconds(reached), all_s);
}

/// The expectations that do not hold, and how many do.
void print_failures(const std::vector<ExpectationResult>& results, bool colour) {
  using Of = ExpectationResult::Verdict;
  std::vector<ExpectationResult> failures;
  std::copy_if(results.begin(), results.end(), std::back_inserter(failures),
               [](const ExpectationResult& result) { return result.verdict > Of::pass; });
  if (!failures.empty()) fmt::print("{}", verdict_table(failures, colour));
  const auto skipped = std::count_if(results.begin(), results.end(),
                                     [](const ExpectationResult& result) { return result.verdict == Of::skipped; });
  const auto judged = static_cast<std::ptrdiff_t>(results.size()) - skipped;
  fmt::print("expectations {} of {} hold{}; --verbose shows all\n", judged - static_cast<std::ptrdiff_t>(failures.size()),
             judged, skipped > 0 ? fmt::format(", {} are for the other clock", skipped) : "");
}

/// A line on what the program's own solver lacks; empty if it lacks nothing.
std::string lacking_line(const SolverRecord& solver) {
  if (solver.lacks.empty()) return "";
  return fmt::format("the solver '{}' lacks {}: what needs them is left out\n", solver.name, fmt::join(solver.lacks, ", "));
}

}  // namespace

void print_outcome(const Scenario& scenario, const RunOutcome& outcome, const std::string& folder,
                   const std::string& program, const std::string& reproduce, bool verbose) {
  const bool colour = isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
  if (!verbose) fmt::print("{}", strategy_table(outcome.record, outcome.metrics));
  if (!outcome.results.empty())
    verbose ? fmt::print("{}", verdict_table(outcome.results, colour)) : print_failures(outcome.results, colour);
  if (!outcome.failure.empty()) fmt::print("stopped: {}\n", with_program(outcome.failure, program));
  if (!outcome.remedy.empty() && outcome.exit != ExitCode::pass)
    fmt::print("remedy: {}\n", with_program(outcome.remedy, program));
  if (!outcome.repeat_difference.empty()) fmt::print("not reproducible: {}\n", outcome.repeat_difference);
  if (outcome.record.clock == "wall" && !outcome.record.real_time_granted) {
    fmt::print("not real-time: the system refused SCHED_FIFO, lateness is the kernel's (see \"rights\")\n");
  }
  if (outcome.case_record) print_case(*outcome.case_record, outcome, folder);
  if (!outcome.record.strategies.empty()) {
    fmt::print("{}{}{}", live_lines(outcome.record, outcome.metrics),
               verbose ? growth_lines(outcome.metrics, outcome.results) : "", device_notes(outcome.record));
    for (const auto& [signal, saturation] : saturations(outcome.record))
      fmt::print("saturated    {}: {}\n", signal, text(saturation));
    fmt::print("{}", suffered_lines(outcome));
    fmt::print("{}", lacking_line(outcome.record.strategies.front().solver));
    fmt::print("trace {:016x}   {} {}, {} simulated in {:.2f} s of CPU time\n", outcome.record.trace_hash,
               outcome.record.strategies.size(), outcome.record.strategies.size() == 1 ? "strategy" : "strategies",
               simulated_text(scenario, outcome), outcome.cpu_seconds);
    fmt::print("{}", compared_lines(outcome));
    if (verbose)
      fmt::print("solver waits       {:.2f} s by the clock, from launch to answer, summed over the strategies\n",
                 outcome.solver_seconds);
    if (outcome.record.clock == "wall" && outcome.repeat_difference.empty() && outcome.exit != ExitCode::interrupted) {
      fmt::print("the recorded inputs replay to the same trace\n");
    }
    fmt::print("figures and data in {}\n", folder);
  }
  if (outcome.exit != ExitCode::pass) fmt::print("again: {}\n", reproduce);
}

std::string_view words(const RunOutcome& outcome) {
  switch (outcome.exit) {
    case ExitCode::pass:
    case ExitCode::expectation_failed:
      break;
    case ExitCode::usage:
      return "ERROR in the scenario";
    case ExitCode::run_failed:
      return "ERROR, the run failed";
    case ExitCode::not_reproducible:
      return "NOT REPRODUCIBLE";
    case ExitCode::interrupted:
      return "INTERRUPTED";
  }
  switch (outcome.verdict) {
    case RunVerdict::pass:
      return "PASS";
    case RunVerdict::none:
      return "NO VERDICT: nothing was asserted; write [[expect]] (--allow-no-expectations exits with 0)";
    case RunVerdict::degraded:
      return "DEGRADED: the machine did not keep real time as expected (--allow-degraded exits with 0)";
    case RunVerdict::fail:
    case RunVerdict::error:
      return "FAIL";
  }
  return "";
}

namespace {

/// Whether the scenario is left out, because it was only found in a folder, not named, and takes long.
bool leave_out(const Scenario& scenario, const RunArguments& arguments) {
  const auto contains = [](const auto& list, const std::string& item) {
    return std::find(list.begin(), list.end(), item) != list.end();
  };
  return !arguments.include_long && contains(scenario.tags, "long") && !contains(arguments.paths, scenario.file);
}

/// Parses "left=/dev/hidraw0", or just the path.
LiveDeviceOptions live_devices_of(const RunArguments& arguments) {
  LiveDeviceOptions options;
  options.forces = arguments.forces;
  options.cores_may_sleep = arguments.cores_may_sleep;
  for (const std::string& device : arguments.devices) {
    const std::size_t equals = device.find('=');
    const bool named = equals < device.find('/');
    options.bindings.push_back(named ? DeviceBinding{device.substr(0, equals), device.substr(equals + 1)}
                                     : DeviceBinding{"", device});
  }
  return options;
}

/// Prints what the person at the device should know before it moves.
void warn_of_devices(const LiveDeviceOptions& options) {
  if (options.bindings.empty()) return;
  if (options.forces)
    spdlog::warn(
        "forces are on: keep a hand on the device and the other one on its switch. evenstep is not a safety device");
  else
    spdlog::info("forces are off, the device is only read; --forces lets them through");
  if (!built_with_hidapi()) return;  // devices of other kinds are driven all the same
  for (const HidListing& listing : hid_devices()) {
    const auto is_it = [&](const DeviceBinding& binding) { return binding.path == listing.info.path; };
    if (listing.force_feedback_node.empty() || std::none_of(options.bindings.begin(), options.bindings.end(), is_it))
      continue;
    spdlog::warn(
        "{}: the kernel's own force-feedback driver holds this device, too ({}); a program that plays effects there will "
        "disturb the forces",
        listing.info.path, listing.force_feedback_node);
  }
}

constexpr const char* kAllLeftOut = "every scenario is left out, they carry the tag \"long\"; add --long";

/// All that one call does with its scenarios.
struct Call {
  const RunArguments& arguments;
  const std::atomic<bool>& interrupted;
  const Registry& registry;
  bool several = false;  ///< false for a single named file; otherwise --json is a list
  std::string date;      ///< when it began
  std::vector<std::string> summaries;
  std::vector<SummaryRow> rows;  ///< of the job's summary, on GitHub
  std::vector<JunitSuite> suites;
};

RunOrigin origin_of(const std::string& file, const Call& call) { return {call.date, commit_of(file, std::getenv)}; }

/// A scenario that cannot be run.
RunOutcome broken(const std::string& file, const std::vector<Diagnostic>& errors, const Call& call) {
  RunOutcome outcome;
  outcome.record.origin = origin_of(file, call);
  outcome.exit = ExitCode::usage;
  outcome.record.scenario = outcome.record.file = file;
  for (const Diagnostic& error : errors) outcome.failure += (outcome.failure.empty() ? "" : "\n") + text(error);
  return outcome;
}

RunOptions options_of(const Call& call) {
  RunOptions options;
  options.devices = live_devices_of(call.arguments);
  options.clock = call.arguments.clock == "wall" ? ClockKind::wall : ClockKind::virtual_clock;
  options.threads = call.arguments.threads;
  options.repeat = call.arguments.repeat;
  options.growths = true;
  options.allow_no_expectations = call.arguments.allow_no_expectations;
  options.allow_degraded = call.arguments.allow_degraded;
  options.control.permute_ties = call.arguments.permute_ties;
  options.control.interrupted = &call.interrupted;
  options.control.picture = true;
  options.record_to = call.arguments.record;
  return options;
}

/// What is said before a run.
void introduce(const Scenario& scenario, const std::string& limits, const RunArguments& arguments) {
  fmt::print("evenstep {}  {}  ({})  seed {}  clock {}\n", kVersion, scenario.name, scenario.file, scenario.seed,
             arguments.clock);
  if (arguments.clock == "wall")
    fmt::print("runs for {:.3g} s; Ctrl-C ends it earlier and keeps what was recorded until then\n",
               seconds(scenario.run_duration));
  fmt::print("{}", limits);
  if (const std::string device = opencl_line(scenario); !device.empty()) fmt::print("  OpenCL       {}\n", device);
  std::fflush(stdout);
}

/// For report.html. (A live run has a timing of its own.)
void put_trusted(const Scenario& scenario, RunRecord& record) {
  for (StrategyRecord& strategy : record.strategies) {
    const StrategyTraits* const traits = strategy_named(strategy.name);
    const auto trusted = traits != nullptr ? trusted_latency(scenario, traits->kind) : std::nullopt;
    if (trusted) strategy.latency.trusted = text(*trusted);
  }
}

/// Writes the run folder, and keeps the summary for --json.
void keep(const std::string& folder, const Scenario& scenario, RunOutcome& outcome, const std::string& reproduce,
          Call& call) {
  std::vector<FolderFile> also;
  if (call.arguments.trace_json && !outcome.record.strategies.empty())
    also.push_back({"trace.json", [&](std::ostream& out) { trace_json(outcome.record, out); }});
  if (call.arguments.clock != "wall") put_trusted(scenario, outcome.record);
  const std::string error = write_run_folder(folder, scenario, outcome, reproduce, also);
  if (!error.empty()) {
    spdlog::error("error: {}", error);
    outcome.exit = worse(outcome.exit, ExitCode::run_failed);
    outcome.failure += (outcome.failure.empty() ? "" : "\n") + error;
  }
  call.suites.push_back(junit_suite(outcome, reproduce));
  if (call.arguments.json) call.summaries.push_back(summary_of(outcome));
}

/// Reports what is wrong with a scenario file.
RunOutcome refuse(const std::string& file, const std::vector<Diagnostic>& errors, const std::string& folder, Call& call) {
  print(errors);
  RunOutcome outcome = broken(file, errors, call);
  call.rows.push_back(summary_row(file, outcome, words(outcome)));
  // A single file that was only mistyped leaves the older run in its usual place alone.
  std::string reproduce = call.arguments.program + " check " + shell_file(file);
  for (const std::string& set : call.arguments.set) reproduce += " --set " + shell_word(set);
  if (!call.several && call.arguments.out.empty()) {
    call.suites.push_back(junit_suite(outcome, reproduce));
    if (call.arguments.json) call.summaries.push_back(summary_of(outcome));
    return outcome;
  }
  Scenario unread;
  unread.file = file;
  keep(folder, unread, outcome, reproduce, call);
  return outcome;
}

/// Shows how far the run is and, on the wall clock, what it does. False if --scope cannot be had; then nothing ran.
bool run_watched(const Scenario& scenario, RunOptions& options, const RunArguments& arguments, RunOutcome& outcome) {
  Progress progress(isatty(STDERR_FILENO));
  options.control.progress = [&](const std::string& strategy, double fraction) { progress.update(strategy, fraction); };
  if (options.clock != ClockKind::wall) {
    outcome = run_scenario(scenario, options);
    return true;
  }
  const Scenario guarded = with_live_guards(scenario, options.devices.bindings);
  LiveWatcher watcher(guarded, options.devices);
  options.control.view = &watcher;
  if (arguments.scope) {
    const Result<std::string> address = watcher.open_scope(static_cast<std::uint16_t>(arguments.scope_port.value_or(0)));
    if (!address) {
      spdlog::error("error: --scope: {}", address.error());
      outcome.exit = ExitCode::run_failed;
      outcome.failure = "--scope: " + address.error();
      return false;
    }
    fmt::print(stderr, "scope: {}\n", *address);
  }
  outcome = run_scenario(scenario, options);
  return true;
}

/// Runs one scenario; nullopt if it was left out.
std::optional<RunOutcome> run_one(const std::string& file, const std::string& folder, Call& call) {
  const RunArguments& arguments = call.arguments;
  const ReadResult read = read_scenario(file, {arguments.set, arguments.seed, call.registry, arguments.clock == "wall"});
  if (!read) return refuse(file, read.error(), folder, call);
  const Scenario& scenario = *read;
  if (leave_out(scenario, arguments)) {
    spdlog::info("{}: left out, it carries the tag \"long\"; --long runs it", file);
    return std::nullopt;
  }
  RunOptions options = options_of(call);
  const std::vector<Diagnostic> missing = missing_in_build(scenario, options.clock, options.devices.bindings);
  if (!missing.empty()) return refuse(file, missing, folder, call);
  std::string limits;
  try {
    if (!scenario.case_spec)
      limits = arguments.verbose ? stability_lines(scenario) + rendering_lines(scenario) : instability_line(scenario);
  } catch (const SolverError& error) {
    return refuse(file, {refusal_of(scenario, error)}, folder, call);
  }
  warn_of_idle_gpu(scenario);
  if (!scenario.timing.trace_damage.empty())
    spdlog::warn("{}: {}", scenario.timing.trace_file, scenario.timing.trace_damage);
  if (!arguments.json) introduce(scenario, limits, arguments);
  RunOutcome outcome;
  if (const std::string objection = run_folder_objection(folder); !objection.empty()) {
    spdlog::error("error: {}", objection);
    outcome.exit = ExitCode::run_failed;
    outcome.failure = objection;
    outcome.record.scenario = scenario.name;
    outcome.record.file = file;
    call.suites.push_back(junit_suite(outcome, reproduce_command(arguments, scenario, folder)));
    return outcome;
  }
  options.origin = origin_of(file, call);
  if (options.clock == ClockKind::wall) warn_of_devices(options.devices);
  options.control.row_files = std::make_shared<RowFiles>(fs::path(folder + "/..").lexically_normal());
  if (!run_watched(scenario, options, arguments, outcome)) {
    outcome.record.scenario = scenario.name;
    outcome.record.file = file;
    call.suites.push_back(junit_suite(outcome, reproduce_command(arguments, scenario, folder)));
    return outcome;
  }
  outcome.record.origin = options.origin;
  if (!outcome.errors.empty()) return refuse(file, outcome.errors, folder, call);
  const std::string reproduce = reproduce_command(arguments, scenario, folder);
  keep(folder, scenario, outcome, reproduce, call);
  if (!arguments.json) {
    print_outcome(scenario, outcome, folder, arguments.program, reproduce, arguments.verbose);
    if (!arguments.record.empty() && !outcome.record.strategies.empty())
      fmt::print("recorded: {} replay {}\n", arguments.program, shell_file(arguments.record));
    fmt::print("{}\n\n", words(outcome));
    std::fflush(stdout);
  }
  annotate_run(file, outcome, words(outcome), reproduce);
  call.rows.push_back(summary_row(file, outcome, words(outcome)));
  return outcome;
}

/// How many scenarios ended in which way.
struct Tally {
  std::size_t passed = 0, failed = 0, undecided = 0, left_out = 0;
  void add(const std::optional<RunOutcome>& outcome) {
    const bool decided = !outcome || (outcome->verdict != RunVerdict::none && outcome->verdict != RunVerdict::degraded);
    ++(!outcome ? left_out : !decided ? undecided : outcome->exit == ExitCode::pass ? passed : failed);
  }
  std::string text(std::size_t files) const {
    const auto other = [](std::size_t count, const char* what) {
      return count > 0 ? fmt::format(", {} {}", count, what) : std::string();
    };
    return fmt::format("{} scenarios: {} passed, {} failed{}{}{}\n", files, passed, failed,
                       other(undecided, "without a verdict"), other(left_out, "left out (long)"),
                       other(files - passed - failed - undecided - left_out, "not run"));
  }
};

/// Writes --junit FILE. A call that was refused before its first run is a suite of its own.
ExitCode write_junit(const Call& call, ExitCode code) {
  if (call.arguments.junit.empty()) return code;
  std::error_code ignored;  // write_text says what is wrong
  if (const auto folder = std::filesystem::path(call.arguments.junit).parent_path(); !folder.empty())
    std::filesystem::create_directories(folder, ignored);
  return write_text(call.arguments.junit, junit_xml(call.suites)) ? code : worse(code, ExitCode::run_failed);
}

/// The summaries as one JSON document: that of the run, or a list where there may be several.
void print_json(const Call& call) {
  if (!call.several) {
    for (const std::string& summary : call.summaries) fmt::print("{}\n", summary);
    return;
  }
  fmt::print("[");
  for (std::size_t i = 0; i < call.summaries.size(); ++i) fmt::print("{}{}", i > 0 ? ",\n" : "", call.summaries[i]);
  fmt::print("]\n");
}

/// A call that ran nothing: JUnit must show that.
ExitCode nothing_ran(Call& call, const std::string& why) {
  const std::string paths = fmt::format("{}", fmt::join(call.arguments.paths, " "));
  call.suites.push_back(junit_suite(broken(paths, {{paths, 0, 0, why}}, call), ""));
  return write_junit(call, ExitCode::usage);
}

/// Why --scope makes no sense here; empty if it does, or is not given.
std::string scope_objection(const RunArguments& arguments) {
  if (arguments.scope_port && !arguments.scope) return "--scope-port is the port of --scope; add that";
  if (!arguments.scope) return "";
  if (arguments.clock != "wall")
    return "it shows a run while real time passes, which it does not on the virtual clock; add --clock wall, or open "
           "report.html after the run";
  return built_with_scope() ? "" : refusal_without(build_option::kScope, kInsteadOfScope);
}

ExitCode run(const RunArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  if (arguments.forces && (arguments.devices.empty() || arguments.clock != "wall")) {
    spdlog::error("--forces: error: it lets forces reach a real device; add --clock wall --device PATH, or leave it out");
    return ExitCode::usage;
  }
  if (const std::string objection = scope_objection(arguments); !objection.empty()) {
    spdlog::error("--scope: error: {}", objection);
    return ExitCode::usage;
  }
  const Result<std::string> date = date_of_run(std::getenv, unix_seconds());
  if (!date) {
    print({{"SOURCE_DATE_EPOCH", 0, 0, date.error()}});
    return ExitCode::usage;
  }
  const std::optional<std::vector<std::string>> files = scenario_files(arguments.paths);
  if (!files) {
    Call call{arguments, interrupted, registry, true, *date, {}, {}, {}};
    return nothing_ran(call, "no scenario (*.toml) in a folder");
  }
  const bool one_was_named = files->size() == 1 && files->front() == arguments.paths.front();
  if (!arguments.record.empty() && files->size() > 1) {
    spdlog::error("--record: error: it is the recording of one run, and these are {} scenarios", files->size());
    return ExitCode::usage;
  }
  Call call{arguments, interrupted, registry, !one_was_named, *date, {}, {}, {}};
  const std::vector<std::string> folders = run_places(*files, arguments.out);
  ExitCode worst_code = ExitCode::pass;
  Tally tally;
  for (std::size_t i = 0; i < files->size() && !interrupted; ++i) {
    const std::optional<RunOutcome> outcome = run_one((*files)[i], folders[i], call);
    tally.add(outcome);
    if (outcome) worst_code = worse(worst_code, outcome->exit);
  }
  if (interrupted) worst_code = ExitCode::interrupted;
  add_to_job_summary(call.rows, tally.text(files->size()));
  if (arguments.json)
    print_json(call);
  else if (files->size() > 1)
    fmt::print("{}", tally.text(files->size()));
  if (tally.left_out == files->size()) {
    spdlog::error("error: {}", kAllLeftOut);
    return nothing_ran(call, kAllLeftOut);
  }
  return write_junit(call, worst_code);
}

}  // namespace

void add_run(Commands& commands) {
  auto [command, arguments] = commands.add<RunArguments>("run", "run scenarios and judge their expectations", run);
  arguments.program = commands.program();
  command.operands("scenario", arguments.paths, "scenario files, or folders of them");
  command.option("--clock", arguments.clock, {"virtual", "wall"}, "virtual (default) or wall");
  command.option("--seed", arguments.seed, "instead of [run] seed");
  command.repeated("--set", arguments.set, "path=value, overrides the file: --set timing.visualization=\"20 ms\"");
  command.option("--out,-o", arguments.out,
                 "run folder (one scenario) or folder of run folders (several); default runs/<name>");
  command.option("--junit", arguments.junit,
                 "one JUnit file for all scenarios of this call, besides that of each run folder");
  command.flag("--trace-json", arguments.trace_json,
               "trace.json in the run folder, for ui.perfetto.dev (some MB per second)");
  command.flag("--verbose,-v", arguments.verbose, "print every expectation, how errors grow, and the limits of the solver");
  command.flag("--repeat", arguments.repeat, "run twice; exit 4 and name the first differing event if the traces differ");
  command.option("--permute-ties", arguments.permute_ties,
                 "shuffle the order of simultaneous events of one lane with this seed");
  command.option("--threads", arguments.threads, Range{0, 1024},
                 "strategies side by side; 0 = one per core (results do not depend on it)");
  command.repeated("--device", arguments.devices,
                   "with --clock wall: drive the real device /dev/hidrawN instead of the simulated one; NAME=PATH names the "
                   "[[device]], default the first");
  command.flag("--forces", arguments.forces, "let forces reach the real device; without it, it is only read");
  command.flag("--cores-may-sleep", arguments.cores_may_sleep,
               "with --clock wall: leave /dev/cpu_dma_latency alone, which otherwise keeps cores from sleeping deeply");
  command.option(
      "--record", arguments.record,
      "with --clock wall: write the inputs of the run to this file while it runs; `replay` runs it again from there");
  command.flag("--scope", arguments.scope,
               "with --clock wall: a page that shows the run while it lasts, for a browser of this machine");
  command.option("--scope-port", arguments.scope_port, Range{0, 65535}, "of that page's server; 0 (default): a free one");
  command.flag("--long", arguments.include_long,
               "with a folder: also its scenarios with the tag \"long\" (a file that is named always runs)");
  command.flag("--allow-no-expectations", arguments.allow_no_expectations,
               "exit with 0, not 1, if the scenario asserts nothing (verdict: none)");
  command.flag("--allow-degraded", arguments.allow_degraded,
               "exit with 0, not 1, if only expectations with clock = \"wall\" fail: the machine was too slow (degraded)");
  command.flag("--json", arguments.json,
               "print summary.json instead of tables; for a folder or several files a list of them");
}

}  // namespace evenstep::app
