#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/apps/shell.h"
#include "evenstep/harness/recorded_timing.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/run_failure.h"
#include "evenstep/text/suggest.h"
#include "src/commands.h"
#include "src/progress.h"
#include "src/run_places.h"
#include "src/run_printing.h"

namespace evenstep::app {
namespace {

struct ReplayArguments {
  std::string program, file, out, timing;
  std::vector<std::string> strategies;
  bool before_damage = false, allow_degraded = false, verbose = false, json = false;
};

std::string length_text(const InputLog& log) {
  std::size_t ticks = 0;
  for (const DeviceInputs& inputs : log.inputs) ticks += inputs.ticks.size();
  return fmt::format("{} ticks, {} steps, {} blocks", ticks, log.rows.steps.size(), log.blocks);
}

void introduce(const Scenario& scenario, const InputLog& log) {
  fmt::print("evenstep {}  {}  (recorded {} by evenstep {} from {})\n", kVersion, scenario.name,
             log.head.origin.date.empty() ? "at a time that is not said" : log.head.origin.date, log.head.version,
             log.head.scenario_file);
  fmt::print("recording    {:.6g} s of {:.6g} s: {}\n", seconds(log.until()), seconds(scenario.run_duration),
             length_text(log));
  if (log.damaged)
    fmt::print("block {} is damaged: what stands before it is replayed, and {} bytes from byte {} on are left out\n",
               log.blocks, log.left_bytes, log.bytes);
  else if (!log.end)
    fmt::print(
        "it has no last block: its writer was killed, its disk was full, or the run failed; block {} would begin at "
        "byte {}, {}\n",
        log.blocks, log.bytes,
        log.left_bytes == 0 ? "where the file ends" : fmt::format("and {} bytes are left there", log.left_bytes));
  if (log.end && log.end->interrupted) fmt::print("the run was interrupted\n");
  std::fflush(stdout);
}

/// Keeps the live strategy and those asked for; false, with an error, if one is unknown.
bool choose_strategies(const ReplayArguments& arguments, Scenario& scenario) {
  if (arguments.strategies.empty()) return true;
  std::vector<StrategyKind> chosen{scenario.live};
  for (const std::string& name : arguments.strategies) {
    const StrategyTraits* const found = strategy_named(name);
    if (found == nullptr) {
      std::vector<std::string_view> known;
      for (const StrategyTraits& traits : kAllStrategies) known.emplace_back(traits.name);
      spdlog::error("--strategy: error: '{}' is no strategy{}", name, internal::suggestion(name, known));
      return false;
    }
    if (std::find(chosen.begin(), chosen.end(), found->kind) == chosen.end()) chosen.push_back(found->kind);
  }
  scenario.strategies = std::move(chosen);
  return true;
}

/// The last line. A recording that ends early is only compared, not judged.
std::string last_line(const Scenario& scenario, const RunOutcome& outcome, const InputLog& log) {
  if (log.whole() || outcome.exit != ExitCode::pass) return std::string(words(outcome));
  return fmt::format(
      "EQUAL until {:.6g} s; what follows until {:.6g} s is not in the recording, and no expectation is judged",
      seconds(outcome.record.nominal.end), seconds(scenario.run_duration));
}

RunOptions options_of(const ReplayArguments& arguments, const InputLog& log, const std::atomic<bool>& interrupted) {
  RunOptions options;
  options.clock = ClockKind::wall;
  options.replayed = &log;
  options.devices.bindings = log.head.devices;
  options.growths = true;
  options.allow_no_expectations = true;
  options.allow_degraded = arguments.allow_degraded;
  options.control.permute_ties = log.head.permute_ties;
  options.control.interrupted = &interrupted;
  return options;
}

/// The command that does this again.
std::string again(const ReplayArguments& arguments) {
  std::string command = fmt::format("{} replay {}", arguments.program, shell_file(arguments.file));
  for (const std::string& strategy : arguments.strategies) command += " --strategy " + shell_word(strategy);
  if (arguments.before_damage) command += " --before-damage";
  if (arguments.allow_degraded) command += " --allow-degraded";
  if (!arguments.out.empty()) command += " --out " + shell_word(arguments.out);
  return command;
}

RunOutcome run_again(const Scenario& scenario, RunOptions options) {
  Progress progress(isatty(STDERR_FILENO));
  options.control.progress = [&](const std::string& strategy, double fraction) { progress.update(strategy, fraction); };
  return run_scenario(scenario, options);
}

ExitCode replay_log(const ReplayArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  const std::string folder = run_places({arguments.file}, arguments.out).front();
  if (const std::string objection = is_input_log(arguments.file) ? run_folder_objection(folder) : ""; !objection.empty()) {
    spdlog::error("error: {}", objection);
    return ExitCode::run_failed;
  }
  // The rows of a long recording are in files, beside the folder.
  const auto row_files = std::make_shared<RowFiles>(std::filesystem::path(folder + "/..").lexically_normal());
  const InputLogResult log = read_input_log(arguments.file, {arguments.before_damage, row_files});
  if (!log) {
    print(log.error());
    return ExitCode::usage;
  }
  ReadResult read = scenario_of(*log, registry);
  if (!read) {
    print(read.error());
    return ExitCode::usage;
  }
  Scenario& scenario = *read;
  if (!choose_strategies(arguments, scenario)) return ExitCode::usage;
  if (!arguments.json) introduce(scenario, *log);
  if (!arguments.timing.empty()) {
    const auto write = [&](std::ostream& out) { write_recorded_timing(log->rows, out); };
    if (!write_text(arguments.timing, write)) return ExitCode::run_failed;
    if (!arguments.json) fmt::print("wrote {}\n", arguments.timing);
  }
  RunOptions options = options_of(arguments, *log, interrupted);
  options.control.row_files = row_files;
  RunOutcome outcome = run_again(scenario, std::move(options));
  outcome.record.origin = log->head.origin;
  if (!outcome.errors.empty()) {
    print(outcome.errors);
    return ExitCode::usage;
  }
  const std::string reproduce = again(arguments);
  if (const std::string error = write_run_folder(folder, scenario, outcome, reproduce); !error.empty()) {
    spdlog::error("error: {}", error);
    outcome.exit = worse(outcome.exit, ExitCode::run_failed);
  }
  if (arguments.json) {
    fmt::print("{}\n", summary_of(outcome));
  } else {
    print_outcome(scenario, outcome, folder, arguments.program, reproduce, arguments.verbose);
    if (outcome.exit == ExitCode::not_reproducible)
      fmt::print("recorded by evenstep {}, compiler {}; this is {}, compiler {}\n", log->head.version, log->head.build,
                 kVersion, compiler_here());
    fmt::print("{}\n", last_line(scenario, outcome, *log));
  }
  return outcome.exit;
}

ExitCode replay(const ReplayArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  try {
    return replay_log(arguments, interrupted, registry);
  } catch (const RunFailure& failure) {  // there is no room for the rows of the recording
    spdlog::error("error: {}; {}", failure.what(), failure.remedy);
    return ExitCode::run_failed;
  }
}

}  // namespace

void add_replay(Commands& commands) {
  auto [command, arguments] = commands.add<ReplayArguments>(
      "replay", "a recording of a live run (run --record) again, on the virtual clock; exit 4 if it is not the same",
      replay);
  arguments.program = commands.program();
  command.operand("file", arguments.file, "what `run --clock wall --record FILE` has written");
  command.option("--out,-o", arguments.out, "run folder; default runs/<name>");
  command.option("--timing", arguments.timing, "write how long its segments and steps took, for `size` and [timing] trace");
  command.repeated("--strategy", arguments.strategies,
                   "with this one beside the live one, over the recorded samples; default: those of the scenario");
  command.flag("--before-damage", arguments.before_damage, "replay what stands before the first block that is damaged");
  command.flag("--allow-degraded", arguments.allow_degraded,
               "exit with 0, not 1, if only expectations with clock = \"wall\" fail");
  command.flag("--verbose,-v", arguments.verbose, "print every expectation, and how errors grow");
  command.flag("--json", arguments.json, "print summary.json instead of tables");
}

}  // namespace evenstep::app
