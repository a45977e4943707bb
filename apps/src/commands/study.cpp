#include "evenstep/campaigns/study.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <type_traits>

#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/felt_study.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "evenstep/campaigns/study_parts.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/run_failure.h"
#include "src/commands.h"
#include "src/merged_results.h"
#include "src/part_arguments.h"
#include "src/progress.h"

namespace evenstep::app {
namespace {

struct StudyArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set;
  std::string advise, cache;
  PartArguments part;
  bool json = false;
};

std::string folder_for(const StudyArguments& arguments) { return folder_for(arguments.part, arguments.file, "study"); }

/// The command that does this again.
std::string again(const StudyArguments& arguments) {
  std::string command = fmt::format("{} study {}", arguments.program, shell_file(arguments.file));
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  if (!arguments.advise.empty()) command += " --advise " + shell_word(arguments.advise);
  if (!arguments.part.out.empty()) command += " --out " + shell_word(arguments.part.out);
  return command;
}

StudyRecord measure(const Scenario& scenario, const std::atomic<bool>& interrupted) {
  Progress progress(isatty(STDERR_FILENO));
  StudyControl control;
  control.interrupted = &interrupted;
  control.progress = [&](double fraction) { progress.update("study", fraction); };
  return run_study(scenario, control);
}

/// Where references are kept: --cache, or the user's folder for such things; empty if there is none.
std::string cache_folder(const StudyArguments& arguments) {
  if (!arguments.cache.empty()) return arguments.cache;
  const auto below = [](const char* name, const char* rest) -> std::string {
    const char* const folder = std::getenv(name);
    const bool usable = folder != nullptr && std::filesystem::path(folder).is_absolute();
    return usable ? (std::filesystem::path(folder) / rest).string() : "";
  };
  const std::string named = below("XDG_CACHE_HOME", "evenstep");
  return named.empty() ? below("HOME", ".cache/evenstep") : named;
}

/// Prints what is studied. Returns false, with an error, if the folder cannot be written.
bool begin(const StudyArguments& arguments, const Scenario& scenario, const std::string& folder) {
  if (const std::string objection = run_folder_objection(folder, kStudyFile); !objection.empty()) {
    spdlog::error("error: {}", objection);
    return false;
  }
  if (!arguments.json) {
    fmt::print("evenstep {}  study  {}  ({})\n", kVersion, scenario.name, scenario.file);
    std::fflush(stdout);
  }
  return true;
}

ExitCode study_scenario(const StudyArguments& arguments, const Scenario& scenario, const std::optional<StudyGoal>& goal,
                        const std::atomic<bool>& interrupted) {
  const std::string folder = folder_for(arguments);
  if (!begin(arguments, scenario, folder)) return ExitCode::run_failed;
  const StudyRecord record = measure(scenario, interrupted);
  fmt::print("{}", arguments.json ? study_json(record) : study_table(record));
  ExitCode code = ExitCode::pass;
  if (goal) {
    const StudyAdvice advice = advise(record, *goal);
    fmt::print(arguments.json ? stderr : stdout, "{}\n", advice.text);
    if (advice.cell == nullptr) code = ExitCode::expectation_failed;
  }
  if (const std::string error = write_study_folder(folder, scenario, record, again(arguments)); !error.empty()) {
    spdlog::error("error: {}", error);
    code = ExitCode::run_failed;
  } else if (!arguments.json) {
    fmt::print("figures and data in {}\n", folder);
  }
  return interrupted ? ExitCode::interrupted : code;
}

/// The error of the force that the hand feels.
ExitCode felt_study(const StudyArguments& arguments, const Scenario& scenario, const std::optional<StudyGoal>& goal,
                    const std::atomic<bool>& interrupted) {
  const std::string folder = folder_for(arguments);
  if (!begin(arguments, scenario, folder)) return ExitCode::run_failed;
  FeltStudyRecord record;
  {
    Progress progress(isatty(STDERR_FILENO));
    FeltStudyControl control;
    control.interrupted = &interrupted;
    control.cache_folder = cache_folder(arguments);
    control.progress = [&](double fraction) { progress.update("study", fraction); };
    control.announce = [&](const std::string& line) {
      fmt::print(arguments.json ? stderr : stdout, "  {}\n", line);
      std::fflush(stdout);
    };
    record = run_felt_study(scenario, control);
  }
  fmt::print("{}", arguments.json ? felt_study_json(record) : felt_study_table(record));
  ExitCode code = ExitCode::pass;
  if (goal) {
    const FeltAdvice advice = advise(record, *goal);
    fmt::print(arguments.json ? stderr : stdout, "{}\n", advice.text);
    if (!advice.found) code = ExitCode::expectation_failed;
  }
  if (const std::string error = write_felt_study_folder(folder, scenario, record, again(arguments)); !error.empty()) {
    spdlog::error("error: {}", error);
    code = ExitCode::run_failed;
  } else if (!arguments.json) {
    fmt::print("figure and data in {}\n", folder);
  }
  return interrupted ? ExitCode::interrupted : code;
}

/// The other kind of study: how stiff the scene may be.
ExitCode stiffness_limits(const StudyArguments& arguments, const Scenario& scenario, const std::atomic<bool>& interrupted) {
  const std::string folder = folder_for(arguments);
  if (!begin(arguments, scenario, folder)) return ExitCode::run_failed;
  StudyControl control;
  control.interrupted = &interrupted;
  const StiffnessLimits limits = run_stiffness_limits(scenario, control);
  fmt::print("{}", arguments.json ? stiffness_json(limits) : stiffness_table(limits));
  if (const std::string error = write_stiffness_folder(folder, scenario, limits, again(arguments)); !error.empty()) {
    spdlog::error("error: {}", error);
    return ExitCode::run_failed;
  }
  if (!arguments.json) fmt::print("data in {}\n", folder);
  return interrupted ? ExitCode::interrupted : ExitCode::pass;
}

/// --advise on a record of a study's lines. `code` becomes 1 if nothing meets the goal.
template <class Record>
void advise_on(const Record& record, const StudyGoal& goal, bool json, ExitCode& code) {
  const auto advice = advise(record, goal);
  fmt::print(json ? stderr : stdout, "{}\n", advice.text);
  if constexpr (std::is_same_v<Record, StudyRecord>) {
    if (advice.cell == nullptr) code = ExitCode::expectation_failed;
  } else {
    if (!advice.found) code = ExitCode::expectation_failed;
  }
}

/// Prints the results of a study whose lines are complete, and returns their files. `code` becomes 1 if nothing meets the
/// goal.
std::vector<FolderFile> results(const StudyArguments& arguments, const Scenario& scenario,
                                const std::optional<StudyGoal>& goal, const StudyPartsOutcome& outcome, ExitCode& code) {
  std::vector<FolderFile> files;
  if (const auto* state = std::get_if<StudyRecord>(&outcome.record)) {
    fmt::print("{}", arguments.json ? study_json(*state) : study_table(*state));
    if (goal) advise_on(*state, *goal, arguments.json, code);
    files = study_files(scenario, *state, again(arguments));
  } else if (const auto* felt = std::get_if<FeltStudyRecord>(&outcome.record)) {
    fmt::print("{}", arguments.json ? felt_study_json(*felt) : felt_study_table(*felt));
    if (goal) advise_on(*felt, *goal, arguments.json, code);
    files = felt_study_files(scenario, *felt, again(arguments));
  } else if (const auto* limits = std::get_if<StiffnessLimits>(&outcome.record)) {
    fmt::print("{}", arguments.json ? stiffness_json(*limits) : stiffness_table(*limits));
    files = stiffness_files(scenario, *limits, again(arguments));
  }
  return files;
}

/// The results go into the folder of the lines, file by file; parts that may be there are left alone.
ExitCode finish_parts(const StudyArguments& arguments, const Scenario& scenario, const std::optional<StudyGoal>& goal,
                      const StudyPartsOutcome& outcome) {
  ExitCode code = outcome.exit;
  for (const FolderFile& file : results(arguments, scenario, goal, outcome, code)) {
    std::ostringstream text;
    file.write(text);
    if (!write_text((std::filesystem::path(folder_for(arguments)) / file.name).string(), text.str()))
      code = worse(code, ExitCode::run_failed);
  }
  if (!arguments.json) fmt::print("{} of {} points in {}\n", outcome.done, outcome.items, outcome.file);
  return code;
}

/// --shard and --resume.
ExitCode study_parts(const StudyArguments& arguments, const Scenario& scenario, const std::optional<StudyGoal>& goal,
                     const std::atomic<bool>& interrupted, const Registry& registry) {
  StudyPartsOptions options;
  options.set = arguments.set;
  options.registry = registry;
  options.cache_folder = cache_folder(arguments);
  if (!put_part(arguments.part, folder_for(arguments), interrupted, options)) return ExitCode::usage;
  if (options.shard.of > 1 && goal) {
    print({{"--advise", 0, 0, "needs all cells; leave it out, and give it when the merged study is read"}});
    return ExitCode::usage;
  }
  StudyPartsOutcome outcome;
  {
    CountProgress progress(isatty(STDERR_FILENO));
    options.progress = [&](std::int64_t done, std::int64_t of, std::int64_t) { progress.update(done, of, ""); };
    options.announce = [](const std::string& line) { fmt::print(stderr, "  {}\n", line); };
    outcome = run_study_parts(scenario, arguments.file, options);
  }
  if (!said_why(outcome)) return outcome.exit;
  if (outcome.exit == ExitCode::interrupted)
    spdlog::error("interrupted after {} points; --resume goes on from there", outcome.done);
  return finish_parts(arguments, scenario, goal, outcome);
}

/// Why a scenario that was read cannot be studied.
std::vector<Diagnostic> objections(const Scenario& scenario, const std::optional<StudyGoal>& goal) {
  std::string objection;
  if (scenario.study.stiffness_limit) {
    if (goal) objection = "--advise picks among steps, and [study] stiffness_limit compares none; leave one out";
  } else if (scenario.study.error == StudyError::felt_force) {
    objection = felt_study_objection(scenario);
    if (goal && goal->quantity != StudyQuantity::force)
      objection = "--advise: a study of the felt force knows no other error; write such as \"1 % force\"";
  } else if (!std::holds_alternative<TissueScene>(scenario.scene.body)) {
    objection = "error = \"state\" compares the steps of a tissue; write kind = \"tissue\"";
  }
  if (objection.empty()) return {};
  return {{scenario.file, 0, 0, objection}};
}

/// Exits with 1 if nothing meets the goal of --advise.
ExitCode study(const StudyArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  std::optional<StudyGoal> goal;
  if (!arguments.advise.empty()) {
    const Result<StudyGoal> parsed = parse_goal(arguments.advise);
    if (!parsed) {
      spdlog::error("--advise: error: {}", parsed.error());
      return ExitCode::usage;
    }
    goal = *parsed;
  }
  if (arguments.file.empty() == arguments.part.status.empty()) {
    print({{"study", 0, 0, "takes a scenario file, or --status and the folder of a study's parts"}});
    return ExitCode::usage;
  }
  if (!arguments.part.status.empty()) return print_parts_status(arguments.part, "study");
  if (!arguments.part.in_parts() && (arguments.part.of || arguments.part.threads)) {
    print({{"study", 0, 0,
            "--of and --threads divide the points of --shard or --resume; without these, one is measured "
            "after the other"}});
    return ExitCode::usage;
  }
  const ReadResult read = read_scenario(arguments.file, {arguments.set, std::nullopt, registry});
  const std::vector<Diagnostic> errors = read ? objections(*read, goal) : read.error();
  if (!errors.empty()) {
    print(errors);
    return ExitCode::usage;
  }
  try {
    if (arguments.part.in_parts()) return study_parts(arguments, *read, goal, interrupted, registry);
    if (read->study.stiffness_limit) return stiffness_limits(arguments, *read, interrupted);
    if (read->study.error == StudyError::felt_force) return felt_study(arguments, *read, goal, interrupted);
    return study_scenario(arguments, *read, goal, interrupted);
  } catch (const RunFailure& failure) {
    spdlog::error("{}: error: {}; {}", arguments.file, failure.what(), failure.remedy);
    return ExitCode::run_failed;
  }
}

}  // namespace

std::optional<ExitCode> study_results(const Merged& merged) {
  StudyArguments arguments;
  arguments.program = merged.program;
  arguments.file = merged.subject.file;
  arguments.set = merged.subject.set;
  arguments.json = merged.json;
  const ReadResult scenario = read_scenario(arguments.file, {arguments.set, std::nullopt, merged.registry});
  if (const std::vector<Diagnostic> errors = scenario ? objections(*scenario, {}) : scenario.error(); !errors.empty()) {
    print(errors);
    return std::nullopt;
  }
  StudyPartsOptions options;
  options.set = arguments.set;
  options.registry = merged.registry;
  options.complete_file = merged.file;
  options.interrupted = &merged.interrupted;
  StudyPartsOutcome outcome;
  try {
    outcome = run_study_parts(*scenario, arguments.file, options);
  } catch (const RunFailure& failure) {
    spdlog::error("{}: error: {}; {}", arguments.file, failure.what(), failure.remedy);
    return std::nullopt;
  }
  if (!said_why(outcome)) return std::nullopt;
  ExitCode code = outcome.exit;
  const std::string error = write_folder(merged.folder, results(arguments, *scenario, {}, outcome, code));
  if (!error.empty()) {
    spdlog::error("error: {}", error);
    return ExitCode::run_failed;
  }
  if (!arguments.json) fmt::print("{} points in {}, figures and data in {}\n", outcome.items, outcome.file, merged.folder);
  return code;
}

void add_study(Commands& commands) {
  auto [command, arguments] = commands.add<StudyArguments>(
      "study", "error of the felt force against cost, or of a tissue's state, or the largest stable stiffness", study);
  arguments.program = commands.program();
  command.optional_operand("scenario", arguments.file, "a scenario file; its [study] says what is measured");
  command.repeated("--set", arguments.set, "path=value, overrides the file: --set study.repeats=9");
  command.option("--advise", arguments.advise,
                 "the error to reach, \"1 % force\", \"10 um position\" or \"5 % energy\": names the cheapest method "
                 "and step; exit 1 if none reaches it");
  add_part_options(command, arguments.part, "study", "cells");
  command.option("--out,-o", arguments.part.out,
                 "folder for study.json, study.csv and figures, or of parts; default runs/<name>-study");
  command.option("--cache", arguments.cache,
                 "folder in which references are kept, so that each is computed once; default $XDG_CACHE_HOME/evenstep or "
                 "~/.cache/evenstep");
  command.flag("--json", arguments.json, "print study.json instead of the table");
}

}  // namespace evenstep::app
