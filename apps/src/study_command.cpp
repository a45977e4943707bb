#include "evenstep/campaigns/study.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <filesystem>

#include "commands.h"
#include "evenstep/campaigns/stiffness_limit.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/reports/run_failure.h"
#include "progress.h"

namespace evenstep::app {
namespace {

struct StudyArguments {
  std::string file;
  std::vector<std::string> set;
  std::string out, advise;
  bool json = false;
};

std::string folder_for(const StudyArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  return (default_place() / (std::filesystem::path(arguments.file).stem().string() + "-study")).string();
}

StudyRecord measure(const Scenario& scenario, const std::atomic<bool>& interrupted) {
  Progress progress(isatty(STDERR_FILENO));
  StudyControl control;
  control.interrupted = &interrupted;
  control.progress = [&](double fraction) { progress.update("study", fraction); };
  return run_study(scenario, control);
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
  if (const std::string error = write_study_folder(folder, scenario, record); !error.empty()) {
    spdlog::error("error: {}", error);
    code = ExitCode::run_failed;
  } else if (!arguments.json) {
    fmt::print("figures and data in {}\n", folder);
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
  if (const std::string error = write_stiffness_folder(folder, scenario, limits); !error.empty()) {
    spdlog::error("error: {}", error);
    return ExitCode::run_failed;
  }
  if (!arguments.json) fmt::print("data in {}\n", folder);
  return interrupted ? ExitCode::interrupted : ExitCode::pass;
}

/// Exits with 1 if nothing meets the goal of --advise.
ExitCode study(const StudyArguments& arguments, const std::atomic<bool>& interrupted) {
  std::optional<StudyGoal> goal;
  if (!arguments.advise.empty()) {
    const Result<StudyGoal> parsed = parse_goal(arguments.advise);
    if (!parsed) {
      spdlog::error("--advise: error: {}", parsed.error());
      return ExitCode::usage;
    }
    goal = *parsed;
  }
  const ReadResult read = read_scenario(arguments.file, {arguments.set, std::nullopt});
  std::vector<Diagnostic> errors = read.error_or({});
  const bool limits = read && read->study.stiffness_limit;
  if (limits && goal) {
    errors.push_back(
        {arguments.file, 0, 0, "--advise picks among steps, and [study] stiffness_limit compares none; leave one out"});
  } else if (read && !limits && !std::holds_alternative<TissueScene>(read->scene.body)) {
    errors.push_back({arguments.file, 0, 0,
                      "only a tissue has steps to compare; a study needs kind = \"tissue\" or, with a hand "
                      "that feels the force, [study] stiffness_limit = { from = \"20 N/m\", to = \"30000 N/m\" }"});
  }
  if (!errors.empty()) {
    print(errors);
    return ExitCode::usage;
  }
  try {
    if (limits) return stiffness_limits(arguments, *read, interrupted);
    return study_scenario(arguments, *read, goal, interrupted);
  } catch (const RunFailure& failure) {
    spdlog::error("{}: error: {}; {}", arguments.file, failure.what(), failure.remedy);
    return ExitCode::run_failed;
  }
}

}  // namespace

void add_study(Commands& commands) {
  auto [command, arguments] = commands.add<StudyArguments>(
      "study", "error against run time of a tissue, or the largest stable stiffness in a hand", study);
  command.operand("scenario", arguments.file, "a scenario file with kind = \"tissue\", or with [study] stiffness_limit");
  command.repeated("--set", arguments.set, "path=value, overrides the file: --set study.repeats=9");
  command.option("--advise", arguments.advise,
                 "the error to reach, \"1 % force\", \"10 um position\" or \"5 % energy\": names the cheapest method "
                 "and step; exit 1 if none reaches it");
  command.option("--out", arguments.out, "folder for study.json, study.csv and figures; default runs/<name>-study");
  command.flag("--json", arguments.json, "print study.json instead of the table");
}

}  // namespace evenstep::app
