#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "evenstep/apps/shell.h"
#include "evenstep/campaigns/catalogue_parts.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/reports/json.h"
#include "src/commands.h"
#include "src/merged_results.h"
#include "src/part_arguments.h"
#include "src/progress.h"
#include "src/run_places.h"
#include "src/run_printing.h"

namespace evenstep::app {
namespace {

struct CatalogueArguments {
  std::string program;
  std::vector<std::string> paths, set;
  PartArguments part;
  bool include_long = false, json = false;
};

/// The command that runs one of the scenarios alone.
std::string alone(const CatalogueArguments& arguments, const Scenario& scenario) {
  std::string command = fmt::format("{} run {}", arguments.program, shell_file(scenario.file));
  for (const std::string& set : arguments.set) command += " --set " + shell_word(set);
  return command;
}

/// Writes the run folder of a case, and prints the outcome unless the output is JSON.
ExitCode show(const CatalogueArguments& arguments, const CatalogueEntry& entry, const std::string& folder) {
  const std::string reproduce = alone(arguments, *entry.scenario);
  ExitCode code = ExitCode::pass;
  if (!arguments.json) fmt::print("{}  ({})\n", entry.scenario->name, entry.scenario->file);
  if (entry.outcome.case_record) {
    if (!arguments.json) print_outcome(*entry.scenario, entry.outcome, folder, arguments.program, reproduce, true);
    if (const std::string error = write_run_folder(folder, *entry.scenario, entry.outcome, reproduce); !error.empty()) {
      spdlog::error("error: {}", error);
      code = ExitCode::run_failed;
    }
  } else if (!arguments.json) {
    if (!entry.outcome.failure.empty()) fmt::print("{}\n", entry.outcome.failure);
    fmt::print("trace {:016x}   again, with figures: {}\n", entry.outcome.record.trace_hash, reproduce);
  }
  if (!arguments.json) fmt::print("{}\n\n", words(entry.outcome));
  return code;
}

Json json_of(const CatalogueEntry& entry) {
  Json out = {{"scenario", entry.scenario->name}, {"file", entry.scenario->file}, {"verdict", words(entry.outcome)}};
  if (!entry.outcome.failure.empty()) out["failure"] = entry.outcome.failure;
  out["trace"] = fmt::format("{:016x}", entry.outcome.record.trace_hash);
  return out;
}

/// Does what `options` ask for. If that is the whole, or complete already, each scenario is judged, with a run folder below
/// `folder`. If it could not be done, prints why and returns nothing; `failed` is then the exit code.
std::optional<ExitCode> judge(const CatalogueArguments& arguments, CatalogueOptions& options, const std::string& folder,
                              ExitCode& failed) {
  std::int64_t judged = 0, passed = 0;
  ExitCode code = ExitCode::pass;
  Json scenarios = Json::array();
  CatalogueOutcome outcome;
  {
    CountProgress progress(isatty(STDERR_FILENO));
    options.progress = [&](std::int64_t done, std::int64_t of, std::int64_t) { progress.update(done, of, ""); };
    const std::vector<std::string> places = run_places(options.files, folder);
    outcome = run_catalogue(options, [&](CatalogueEntry& entry) {
      const auto at = std::find(options.files.begin(), options.files.end(), entry.scenario->file);
      const std::string& place = places[static_cast<std::size_t>(at - options.files.begin())];
      code = worse(code, show(arguments, entry, options.files.size() > 1 ? place : place + "/run"));
      scenarios.push_back(json_of(entry));
      ++judged;
      passed += entry.outcome.exit == ExitCode::pass ? 1 : 0;
    });
  }
  if (!said_why(outcome)) {
    failed = outcome.exit;
    return std::nullopt;
  }
  if (outcome.exit == ExitCode::interrupted)
    spdlog::error("interrupted after {} points; --resume goes on from there", outcome.done);
  if (arguments.json) {
    const Json all = {{"format", 1},
                      {"scenarios", scenarios},
                      {"passed", passed},
                      {"failed", judged - passed},
                      {"left_out", outcome.left_out},
                      {"done", outcome.done},
                      {"points", outcome.items},
                      {"lines", outcome.file}};
    fmt::print("{}\n", json_text(all, "scenarios"));
  } else {
    if (judged > 0)
      fmt::print("{} scenarios: {} passed, {} failed, {} left out (long)\n", judged, passed, judged - passed,
                 outcome.left_out);
    fmt::print("{} of {} points in {}\n", outcome.done, outcome.items, outcome.file);
  }
  return worse(outcome.exit, code);
}

ExitCode catalogue(const CatalogueArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  if (arguments.paths.empty() == arguments.part.status.empty()) {
    print({{"catalogue", 0, 0, "takes scenario files and folders of them, or --status and the folder of the parts"}});
    return ExitCode::usage;
  }
  if (!arguments.part.status.empty()) return print_parts_status(arguments.part, "catalogue");
  const std::optional<std::vector<std::string>> files = scenario_files(arguments.paths);
  if (!files) return ExitCode::usage;
  CatalogueOptions options;
  options.files = *files;
  options.set = arguments.set;
  options.registry = registry;
  options.long_ones = arguments.include_long;
  const std::string folder = arguments.part.out.empty() ? (default_place() / "catalogue").string() : arguments.part.out;
  if (!put_part(arguments.part, folder, interrupted, options)) return ExitCode::usage;
  ExitCode failed = ExitCode::run_failed;
  return judge(arguments, options, folder, failed).value_or(failed);
}

}  // namespace

std::optional<ExitCode> catalogue_results(const Merged& merged) {
  CatalogueArguments arguments;
  arguments.program = merged.program;
  arguments.set = merged.subject.set;
  arguments.json = merged.json;
  CatalogueOptions options;
  options.files = merged.subject.files;
  options.set = merged.subject.set;
  options.registry = merged.registry;
  options.long_ones = merged.subject.long_ones;
  options.complete_file = merged.file;
  options.interrupted = &merged.interrupted;
  ExitCode failed = ExitCode::run_failed;
  return judge(arguments, options, merged.folder, failed);
}

void add_catalogue(Commands& commands) {
  auto [command, arguments] = commands.add<CatalogueArguments>(
      "catalogue", "the cells of all scenarios with a [case], also in shards on many machines", catalogue);
  arguments.program = commands.program();
  command.optional_operands("scenario", arguments.paths, "scenario files and folders, such as scenarios/stiff");
  command.repeated("--set", arguments.set, "path=value, overrides the files");
  command.flag("--long", arguments.include_long, "also scenarios with the tag \"long\"");
  add_part_options(command, arguments.part, "catalogue", "cells");
  command.option("--out,-o", arguments.part.out,
                 "folder for catalogue.jsonl, or catalogue-I-of-N.jsonl, and for run folders; default runs/catalogue");
  command.flag("--json", arguments.json, "the verdicts as JSON instead of text");
}

}  // namespace evenstep::app
