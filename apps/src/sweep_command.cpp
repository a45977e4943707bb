#include "evenstep/campaigns/sweep.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "commands.h"
#include "evenstep/apps/shell.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/harness/version.h"
#include "evenstep/pages/campaign_pages.h"
#include "progress.h"

namespace evenstep::app {
namespace {

struct SweepArguments {
  std::string program;
  std::string file;
  std::vector<std::string> set;
  std::string shard, out, status;
  std::optional<std::int64_t> of;
  int threads = 0;
  std::optional<std::int64_t> stop_after;
  bool resume = false;
  bool json = false;
};
struct MergeArguments {
  std::string program;
  std::vector<std::string> parts;
  std::string out;
  bool json = false;
};

std::string folder_for(const SweepArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  return (default_place() / (std::filesystem::path(arguments.file).stem().string() + "-sweep")).string();
}

/// Where the page of a sweep is, and the command that makes it again.
struct Page {
  std::filesystem::path file;  ///< empty: there is none, because this is a shard or was interrupted
  std::string reproduce;
};

/// What --shard and --of ask for; what the environment says is printed, so that a job's log shows it.
Result<SweepShard> shard_of(const SweepArguments& arguments) {
  if (arguments.shard.empty() && arguments.of) return Failure("--of belongs to --shard auto");
  if (arguments.shard.empty()) return SweepShard{};
  std::optional<int> of;
  if (arguments.of) of = static_cast<int>(*arguments.of);
  const Result<ShardSaid> said = parse_shard(arguments.shard, of, [](const char* name) { return std::getenv(name); });
  if (!said) return Failure(said.error());
  if (!said->by.empty()) spdlog::info("shard {} of {} ({})", said->shard.index, said->shard.of, said->by);
  return said->shard;
}

/// The report that both commands give at the end.
ExitCode report(const SweepOutcome& outcome, const SweepCommand& command, bool json, const Page& page) {
  if (!outcome.errors.empty()) {
    print(outcome.errors);
    return outcome.exit;
  }
  if (!outcome.failure.empty()) {
    spdlog::error("error: {}", outcome.failure);
    return outcome.exit;
  }
  if (json)
    fmt::print("{}", sweep_json(outcome.header, outcome.summary, command));
  else
    fmt::print("{}points in {}\n", sweep_text(outcome.header, outcome.summary, command), outcome.file);
  if (page.file.empty() || outcome.exit == ExitCode::interrupted) return outcome.exit;
  const char* const verdict = outcome.summary.all.errors > 0 ? "error" : outcome.exit == ExitCode::pass ? "pass" : "fail";
  const std::string text = sweep_page(outcome.header, outcome.summary, command, verdict, page.reproduce);
  return write_text(page.file.string(), text) ? outcome.exit : worse(outcome.exit, ExitCode::run_failed);
}

std::string state_of(const SweepStatus::Part& part) {
  return fmt::format("shard {} of {}: {} of {} points, {} failed{}\n", part.shard.index, part.shard.of, part.done,
                     part.points, part.failed, part.ended ? ", complete" : "");
}

/// At the rate of the whole time until now, which includes pauses.
std::string rate_of(const SweepStatus& status) {
  const std::int64_t done = status.summary.all.runs(), left = status.header.points() - done;
  if (!status.seconds || done == 0) return "";
  const double rate = static_cast<double>(done) / *status.seconds;
  return fmt::format("{:.3g} points a second, about {:.0f} s left\n", rate, std::ceil(static_cast<double>(left) / rate));
}

/// Its exit code says nothing about the points: 0 if the parts could be read.
ExitCode print_status(const SweepArguments& arguments) {
  const Result<SweepStatus> status = sweep_status(arguments.status);
  if (!status) {
    print({{"--status", 0, 0, status.error()}});
    return ExitCode::usage;
  }
  const int of = status->parts.front().shard.of;
  fmt::print("{} of {} points, {} of {} shards have begun\n", status->summary.all.runs(), status->header.points(),
             status->parts.size(), of);
  for (const SweepStatus::Part& part : status->parts) fmt::print("{}", state_of(part));
  fmt::print("{}{}", rate_of(*status), sweep_text(status->header, status->summary, [&](const SweepPoint& point) {
               return point_command(arguments.program, status->header, point, status->header.file);
             }));
  return ExitCode::pass;
}

ExitCode sweep(const SweepArguments& arguments, const std::atomic<bool>& interrupted, const Registry& registry) {
  if (arguments.file.empty() == arguments.status.empty()) {
    print({{"sweep", 0, 0, "takes a scenario file, or --status and the folder of a sweep's parts"}});
    return ExitCode::usage;
  }
  if (!arguments.status.empty()) return print_status(arguments);
  SweepOptions options;
  options.set = arguments.set;
  options.registry = registry;
  options.threads = arguments.threads;
  options.stop_after = arguments.stop_after;
  options.resume = arguments.resume;
  options.folder = folder_for(arguments);
  options.interrupted = &interrupted;
  const Result<SweepShard> shard = shard_of(arguments);
  if (!shard) {
    print({{"--shard", 0, 0, shard.error()}});
    return ExitCode::usage;
  }
  options.shard = *shard;
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
  if (options.shard.of > 1) page.file.clear();  // only the merge can tell
  if (outcome.exit == ExitCode::interrupted)
    spdlog::error("interrupted after {} points; --resume goes on from there", outcome.summary.all.runs());
  return report(
      outcome,
      [&](const SweepPoint& point) { return point_command(arguments.program, outcome.header, point, arguments.file); },
      arguments.json, page);
}

ExitCode merge(const MergeArguments& arguments, const std::atomic<bool>&) {
  const SweepOutcome outcome = merge_sweep(arguments.parts, arguments.out);
  Page page{std::filesystem::path(arguments.out).replace_extension(".html"), arguments.program + " merge"};
  for (const std::string& part : arguments.parts) page.reproduce += ' ' + shell_file(part);
  page.reproduce += " --out " + shell_word(arguments.out);
  return report(
      outcome,
      [&](const SweepPoint& point) { return point_command(arguments.program, outcome.header, point, outcome.header.file); },
      arguments.json, page);
}

}  // namespace

void add_sweep(Commands& commands) {
  auto [command, arguments] =
      commands.add<SweepArguments>("sweep", "every seed with every value of a scenario's [sweep], on all cores", sweep);
  arguments.program = commands.program();
  command.optional_operand("scenario", arguments.file, "a scenario file with a [sweep]");
  command.repeated("--set", arguments.set, "path=value, overrides the file: --set sweep.seeds=\"0..100\"");
  command.option("--shard", arguments.shard, "I/N: every N-th point from the I-th on; auto: as the batch system says");
  command.option("--of", arguments.of, Range{1, kMostShards}, "N: how many shards there are, for --shard auto");
  command.option("--threads", arguments.threads, Range{0, 1024},
                 "points side by side; 0 = one per core (results do not depend on it)");
  command.option("--stop-after", arguments.stop_after, Range{1, 1'000'000'000},
                 "so many failures; instead of [sweep] stop_after");
  command.flag("--resume", arguments.resume, "go on where a sweep was interrupted, or start");
  command.option("--out", arguments.out, "folder for sweep.jsonl or sweep-I-of-N.jsonl; default runs/<name>-sweep");
  command.option("--status", arguments.status, "folder of a sweep's parts: how far it has come; runs nothing");
  command.flag("--json", arguments.json, "the summary as JSON instead of text");
}

void add_merge(Commands& commands) {
  auto [command, arguments] =
      commands.add<MergeArguments>("merge", "the shards of a sweep as one file, with its summary and exit code", merge);
  arguments.program = commands.program();
  command.operands("part", arguments.parts, "sweep-I-of-N.jsonl of all shards, in any order");
  command.required_option("--out", arguments.out, "the file to write: the same bytes as of one process");
  command.flag("--json", arguments.json, "the summary as JSON instead of text");
}

}  // namespace evenstep::app
