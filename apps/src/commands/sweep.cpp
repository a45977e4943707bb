#include "evenstep/campaigns/sweep.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <filesystem>

#include "evenstep/apps/shell.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/pages/campaign_pages.h"
#include "evenstep/reports/json.h"
#include "src/commands.h"
#include "src/merged_results.h"
#include "src/part_arguments.h"
#include "src/progress.h"

namespace evenstep::app {
namespace {

struct SweepArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set;
  PartArguments part;
  std::optional<std::int64_t> stop_after;
  std::string junit;
  bool json = false;
};
struct MergeArguments {
  std::string program;
  std::vector<std::string> parts;
  std::string out, junit;
  bool json = false;
};

/// Where the page of a sweep is, and the command that makes it again.
struct Page {
  std::filesystem::path file;  ///< empty: there is none, because this is a shard or was interrupted
  std::string reproduce;
};

/// The report that both commands give at the end.
ExitCode report(const SweepOutcome& outcome, const SweepCommand& command, bool json, const std::string& junit,
                const Page& page) {
  if (!said_why(outcome)) return outcome.exit;
  if (json)
    fmt::print("{}", sweep_json(outcome.header, outcome.summary, command));
  else
    fmt::print("{}points in {}\n", sweep_text(outcome.header, outcome.summary, command), outcome.file);
  if (!junit.empty() && !write_text(junit, sweep_junit(outcome.header, outcome.summary, command)))
    return worse(outcome.exit, ExitCode::run_failed);
  if (page.file.empty() || outcome.exit == ExitCode::interrupted) return outcome.exit;
  const char* const verdict = outcome.summary.all.errors > 0 ? "error" : outcome.exit == ExitCode::pass ? "pass" : "fail";
  const std::string text = sweep_page(outcome.header, outcome.summary, command, verdict, page.reproduce);
  return write_text(page.file.string(), text) ? outcome.exit : worse(outcome.exit, ExitCode::run_failed);
}

/// The exit code says nothing about the points: it is 0 if the parts could be read.
ExitCode print_status(const SweepArguments& arguments) {
  const Result<SweepStatus> status = sweep_status(arguments.part.status);
  if (!status) {
    print({{"--status", 0, 0, status.error()}});
    return ExitCode::usage;
  }
  fmt::print("{}", status_text(*status));
  fmt::print("{}", sweep_text(status->header, status->summary, [&](const SweepPoint& point) {
               return point_command(arguments.program, status->header, point, status->header.file);
             }));
  return ExitCode::pass;
}

ExitCode sweep(const SweepArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  if (arguments.file.empty() == arguments.part.status.empty()) {
    print({{"sweep", 0, 0, "takes a scenario file, or --status and the folder of a sweep's parts"}});
    return ExitCode::usage;
  }
  if (!arguments.part.status.empty()) return print_status(arguments);
  SweepOptions options;
  options.set = arguments.set;
  options.registry = registry;
  options.stop_after = arguments.stop_after;
  if (!put_part(arguments.part, folder_for(arguments.part, arguments.file, "sweep"), interrupted, options))
    return ExitCode::usage;
  SweepOutcome outcome;
  {
    CountProgress progress(isatty(STDERR_FILENO));
    options.progress = [&](std::int64_t done, std::int64_t of, std::int64_t failed) {
      progress.update(done, of, fmt::format("{} failed", failed));
    };
    outcome = run_sweep(arguments.file, options);
  }
  Page page{std::filesystem::path(options.folder) / kReportFile,
            fmt::format("{} sweep {}", arguments.program, shell_file(arguments.file))};
  for (const std::string& set : arguments.set) page.reproduce += " --set " + shell_word(set);
  if (arguments.stop_after) page.reproduce += fmt::format(" --stop-after {}", *arguments.stop_after);
  if (!arguments.part.out.empty()) page.reproduce += " --out " + shell_word(arguments.part.out);
  if (options.shard.of > 1) page.file.clear();  // only the merge can tell
  if (outcome.exit == ExitCode::interrupted)
    spdlog::error("interrupted after {} points; --resume goes on from there", outcome.summary.all.runs());
  return report(
      outcome,
      [&](const SweepPoint& point) { return point_command(arguments.program, outcome.header, point, arguments.file); },
      arguments.json, arguments.junit, page);
}

/// Parts of a study, a sizing or the catalogue. Only their own command knows what their lines mean.
ExitCode merge_others(const MergeArguments& arguments, const std::string& kind, const std::atomic<bool>& interrupted,
                      const Registry& registry) {
  if (!arguments.junit.empty()) {
    print({{"--junit", 0, 0, fmt::format("a {} has no points that pass or fail; leave it out", kind)}});
    return ExitCode::usage;
  }
  const PartOutcome outcome = merge_parts(arguments.parts, arguments.out);
  if (!said_why(outcome)) return outcome.exit;
  const Result<PartSubject> subject = subject_of_part(outcome.file);
  if (!subject) {
    spdlog::error("{}", subject.error());
    return ExitCode::run_failed;
  }
  const Merged merged{arguments.program, outcome.file,   std::filesystem::path(outcome.file).replace_extension().string(),
                      *subject,          arguments.json, interrupted,
                      registry};
  const std::optional<ExitCode> code = kind == "study"  ? study_results(merged)
                                       : kind == "size" ? size_results(merged)
                                                        : catalogue_results(merged);
  if (code) return *code;
  spdlog::error(
      "error: the lines are merged in {}, but there are no results; merge again in the folder that the shards ran "
      "in, where {} is as it was for them, with the same program",
      outcome.file, subject->file);
  return ExitCode::run_failed;
}

ExitCode merge(const MergeArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  std::string kind;
  for (std::size_t i = 0; i < arguments.parts.size() && kind.empty(); ++i) kind = kind_of_part(arguments.parts[i]);
  if (kind != "sweep" && !kind.empty()) return merge_others(arguments, kind, interrupted, registry);
  const SweepOutcome outcome = merge_sweep(arguments.parts, arguments.out);
  Page page{std::filesystem::path(arguments.out).replace_extension(".html"), arguments.program + " merge"};
  for (const std::string& part : arguments.parts) page.reproduce += ' ' + shell_file(part);
  page.reproduce += " --out " + shell_word(arguments.out);
  return report(
      outcome,
      [&](const SweepPoint& point) { return point_command(arguments.program, outcome.header, point, outcome.header.file); },
      arguments.json, arguments.junit, page);
}

}  // namespace

void add_sweep(Commands& commands) {
  auto [command, arguments] =
      commands.add<SweepArguments>("sweep", "every seed with every value of a scenario's [sweep], on all cores", sweep);
  arguments.program = commands.program();
  command.optional_operand("scenario", arguments.file, "a scenario file with a [sweep]");
  command.repeated("--set", arguments.set, "path=value, overrides the file: --set sweep.seeds=\"0..100\"");
  command.option("--stop-after", arguments.stop_after, Range{1, 1'000'000'000},
                 "so many failures; instead of [sweep] stop_after");
  add_part_options(command, arguments.part, "sweep", "points");
  command.option("--out,-o", arguments.part.out, "folder for sweep.jsonl or sweep-I-of-N.jsonl; default runs/<name>-sweep");
  command.option("--junit", arguments.junit, "file.xml: a testcase for each point that does not pass, for CI");
  command.flag("--json", arguments.json, "the summary as JSON instead of text");
}

void add_merge(Commands& commands) {
  auto [command, arguments] = commands.add<MergeArguments>(
      "merge", "the shards of a sweep, study, sizing or catalogue as one file, with its results and exit code", merge);
  arguments.program = commands.program();
  command.operands("part", arguments.parts, "sweep-I-of-N.jsonl (or study-, size-, catalogue-) of all shards, in any order");
  command.required_option("--out,-o", arguments.out,
                          "the file to write: the same bytes as of one process; results beside it");
  command.option("--junit", arguments.junit, "file.xml, of a sweep: a testcase for each point that does not pass, for CI");
  command.flag("--json", arguments.json, "the summary, or the results, as JSON instead of text");
}

}  // namespace evenstep::app
