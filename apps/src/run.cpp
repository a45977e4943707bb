#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "commands.h"
#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/sweep.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/writers.h"
#include "progress.h"

namespace evenstep::app {
namespace fs = std::filesystem;
namespace {

struct RunArguments {
  std::vector<std::string> paths;
  std::string clock = "virtual";
  std::optional<std::uint64_t> seed;
  std::vector<std::string> set;
  std::string out;
  bool repeat = false;
  std::optional<std::uint64_t> permute_ties;
  int threads = 0;
  bool json = false;
  std::vector<std::string> devices;  ///< NAME=PATH or PATH
  bool forces = false;
  bool include_long = false;  ///< also run scenarios with the tag "long" that are found in a folder
};

/// The command that runs this again.
std::string reproduce_command(const RunArguments& arguments, const Scenario& scenario) {
  std::string command = "evenstep run " + shell_word(scenario.file) + fmt::format(" --seed {}", scenario.seed);
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  if (arguments.clock != "virtual") command += " --clock " + arguments.clock;
  for (const std::string& device : arguments.devices) command += " --device " + shell_word(device);
  if (arguments.forces) command += " --forces";
  if (arguments.permute_ties) command += fmt::format(" --permute-ties {}", *arguments.permute_ties);
  if (arguments.repeat) command += " --repeat";
  return command;
}

/// Where the run folder of each scenario goes. If two scenarios have the same file name, the name of their folder is put in
/// front.
std::vector<std::string> run_folders(const std::vector<std::string>& files, const std::string& out) {
  if (files.size() == 1 && !out.empty()) return {out};
  std::map<std::string, int> stems;
  for (const std::string& file : files) ++stems[fs::path(file).stem().string()];
  std::vector<std::string> folders;
  for (const std::string& file : files) {
    const fs::path path(file);
    std::string name = path.stem().string();
    if (stems[name] > 1) name = path.parent_path().filename().string() + "-" + name;
    folders.push_back(((out.empty() ? default_place() : fs::path(out)) / name).string());
  }
  return folders;
}

void print_case(const CaseRecord& record, const RunOutcome& outcome, const std::string& folder) {
  std::size_t cells = 0;
  for (const CaseRow& row : record.rows) cells += row.cells.size();
  fmt::print("{}", case_table(record));
  fmt::print("trace {:016x}   {} cells, each on two schedules, in {:.2f} s CPU\n", outcome.record.trace_hash, cells,
             outcome.cpu_seconds);
  fmt::print("figures and data in {}\n", folder);
}

void print_outcome(const Scenario& scenario, const RunOutcome& outcome, const std::string& folder,
                   const std::string& reproduce) {
  const bool colour = isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
  fmt::print("{}", verdict_table(outcome.results, colour));
  if (!outcome.failure.empty()) fmt::print("stopped: {}\n", outcome.failure);
  if (!outcome.remedy.empty() && outcome.exit != ExitCode::pass) fmt::print("remedy: {}\n", outcome.remedy);
  if (!outcome.repeat_difference.empty()) fmt::print("not reproducible: {}\n", outcome.repeat_difference);
  if (outcome.record.clock == "wall" && !outcome.record.real_time_granted) {
    fmt::print("not real-time: the system refused SCHED_FIFO, lateness is the kernel's\n");
  }
  if (outcome.case_record) print_case(*outcome.case_record, outcome, folder);
  if (!outcome.record.strategies.empty()) {
    const std::size_t strategies = outcome.record.strategies.size();
    fmt::print("trace {:016x}   {} strategies, {:.3g} s simulated in {:.2f} s of CPU time\n", outcome.record.trace_hash,
               strategies, seconds(scenario.run_duration), outcome.cpu_seconds);
    fmt::print("solver waits       {:.2f} s by the clock, from launch to answer, summed over the strategies\n",
               outcome.solver_seconds);
    if (outcome.record.clock == "wall" && outcome.repeat_difference.empty() && outcome.exit != ExitCode::interrupted) {
      fmt::print("the recorded inputs replay to the same trace\n");
    }
    fmt::print("figures and data in {}\n", folder);
  }
  if (outcome.exit != ExitCode::pass) fmt::print("again: {}\n", reproduce);
}

std::string_view word(ExitCode code) {
  switch (code) {
    case ExitCode::pass:
      return "PASS";
    case ExitCode::expectation_failed:
      return "FAIL";
    case ExitCode::usage:
      return "ERROR in the scenario";
    case ExitCode::run_failed:
      return "ERROR, the run failed";
    case ExitCode::not_reproducible:
      return "NOT REPRODUCIBLE";
    case ExitCode::interrupted:
      return "INTERRUPTED";
  }
  return "";
}

/// Whether the scenario is left out, because it was only found in a folder, not named, and takes long.
bool leave_out(const Scenario& scenario, const RunArguments& arguments) {
  const auto contains = [](const auto& list, const std::string& item) {
    return std::find(list.begin(), list.end(), item) != list.end();
  };
  return !arguments.include_long && contains(scenario.tags, "long") && !contains(arguments.paths, scenario.file);
}

void print_limits(const Scenario& scenario) {
  try {
    fmt::print("{}{}", stability_lines(scenario), rendering_lines(scenario));
  } catch (const SolverError&) {
    return;  // the run itself will stop for the same reason and report it
  }
  std::fflush(stdout);
}

/// Parses "left=/dev/hidraw0", or just the path.
LiveDeviceOptions live_devices_of(const RunArguments& arguments) {
  LiveDeviceOptions options;
  options.forces = arguments.forces;
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

/// Runs one scenario; nullopt if it was left out.
std::optional<ExitCode> run_one(const std::string& file, const std::string& folder, const RunArguments& arguments,
                                const std::atomic<bool>& interrupted) {
  const ReadResult read = read_scenario(file, {arguments.set, arguments.seed});
  if (!read) {
    print(read.error());
    return ExitCode::usage;
  }
  const Scenario& scenario = *read;
  if (leave_out(scenario, arguments)) {
    spdlog::info("{}: left out, it carries the tag \"long\"; --long runs it", file);
    return std::nullopt;
  }
  if (!arguments.json) {
    fmt::print("evenstep {}  {}  ({})  seed {}  clock {}\n", kVersion, scenario.name, scenario.file, scenario.seed,
               arguments.clock);
    std::fflush(stdout);
  }
  if (!arguments.json && !scenario.case_spec) print_limits(scenario);
  if (const std::string objection = run_folder_objection(folder); !objection.empty()) {
    spdlog::error("error: {}", objection);
    return ExitCode::run_failed;
  }
  RunOptions options;
  options.devices = live_devices_of(arguments);
  options.clock = arguments.clock == "wall" ? ClockKind::wall : ClockKind::virtual_clock;
  options.threads = arguments.threads;
  options.repeat = arguments.repeat;
  options.control.permute_ties = arguments.permute_ties;
  options.control.interrupted = &interrupted;
  if (options.clock == ClockKind::wall) warn_of_devices(options.devices);
  RunOutcome outcome;
  {
    Progress progress(isatty(STDERR_FILENO));
    options.control.progress = [&](const std::string& strategy, double fraction) { progress.update(strategy, fraction); };
    outcome = run_scenario(scenario, options);
  }
  if (!outcome.errors.empty()) {
    print(outcome.errors);
    return outcome.exit;
  }
  const std::string reproduce = reproduce_command(arguments, scenario);
  if (const std::string error = write_run_folder(folder, scenario, outcome, reproduce); !error.empty()) {
    spdlog::error("error: {}", error);
    outcome.exit = worse(outcome.exit, ExitCode::run_failed);
  }
  if (arguments.json) {
    fmt::print("{}\n", summary_of(outcome));
    return outcome.exit;
  }
  print_outcome(scenario, outcome, folder, reproduce);
  fmt::print("{}\n\n", word(outcome.exit));
  std::fflush(stdout);
  return outcome.exit;
}

ExitCode run(const RunArguments& arguments, const std::atomic<bool>& interrupted) {
  const std::optional<std::vector<std::string>> files = scenario_files(arguments.paths);
  if (!files) return ExitCode::usage;
  const std::vector<std::string> folders = run_folders(*files, arguments.out);
  ExitCode worst_code = ExitCode::pass;
  std::size_t passed = 0, ran = 0, left_out = 0;
  for (std::size_t i = 0; i < files->size() && !interrupted; ++i) {
    const std::optional<ExitCode> code = run_one((*files)[i], folders[i], arguments, interrupted);
    if (!code) {
      ++left_out;
      continue;
    }
    worst_code = worse(worst_code, *code);
    passed += *code == ExitCode::pass;
    ++ran;
  }
  if (interrupted) worst_code = ExitCode::interrupted;
  if (files->size() > 1 && !arguments.json) {
    const std::size_t not_run = files->size() - ran - left_out;
    fmt::print("{} scenarios: {} passed, {} failed{}{}\n", files->size(), passed, ran - passed,
               left_out > 0 ? fmt::format(", {} left out (long)", left_out) : "",
               not_run > 0 ? fmt::format(", {} not run", not_run) : "");
  }
  return worst_code;
}

}  // namespace

void add_run(Commands& commands) {
  auto [command, arguments] = commands.add<RunArguments>("run", "run scenarios and judge their expectations", run);
  command.operands("scenario", arguments.paths, "scenario files, or folders of them");
  command.option("--clock", arguments.clock, {"virtual", "wall"}, "virtual (default) or wall");
  command.option("--seed", arguments.seed, "instead of [run] seed");
  command.repeated("--set", arguments.set, "path=value, overrides the file: --set timing.visualization=\"20 ms\"");
  command.option("--out", arguments.out,
                 "run folder (one scenario) or folder of run folders (several); default runs/<name>");
  command.flag("--repeat", arguments.repeat, "run twice; exit 4 and name the first differing event if the traces differ");
  command.option("--permute-ties", arguments.permute_ties,
                 "shuffle the order of simultaneous events of one lane with this seed");
  command.option("--threads", arguments.threads, Range{0, 1024},
                 "strategies side by side; 0 = one per core (results do not depend on it)");
  command.repeated("--device", arguments.devices,
                   "with --clock wall: drive the real device /dev/hidrawN instead of the simulated one; NAME=PATH names the "
                   "[[device]], default the first");
  command.flag("--forces", arguments.forces, "let forces reach the real device; without it, it is only read");
  command.flag("--long", arguments.include_long,
               "with a folder: also its scenarios with the tag \"long\" (a file that is named always runs)");
  command.flag("--json", arguments.json, "print summary.json of each run instead of tables");
}

}  // namespace evenstep::app
