#include "evenstep/campaigns/sweep.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "commands.h"
#include "evenstep/harness/version.h"
#include "progress.h"

namespace evenstep::app {
namespace {

std::string folder_for(const SweepArguments& arguments) {
  if (!arguments.out.empty()) return arguments.out;
  return (default_place() / (std::filesystem::path(arguments.file).stem().string() + "-sweep")).string();
}

/// What both commands say at the end.
ExitCode report(const SweepOutcome& outcome, const SweepCommand& command, bool json) {
  if (!outcome.errors.empty()) {
    print(outcome.errors);
    return outcome.exit;
  }
  if (!outcome.failure.empty()) {
    spdlog::error("error: {}", outcome.failure);
    return outcome.exit;
  }
  if (json)
    fmt::print("{}", sweep_json(outcome.record, outcome.summary, command));
  else
    fmt::print("{}points in {}\n", sweep_text(outcome.record, outcome.summary, command), outcome.file);
  return outcome.exit;
}

}  // namespace

ExitCode sweep(const SweepArguments& arguments, const std::atomic<bool>& interrupted) {
  SweepOptions options;
  options.set = arguments.set;
  options.threads = arguments.threads;
  options.stop_after = arguments.stop_after;
  options.resume = arguments.resume;
  options.folder = folder_for(arguments);
  options.interrupted = &interrupted;
  if (!arguments.shard.empty()) {
    const Parsed<SweepShard> shard = parse_shard(arguments.shard, [](const char* name) { return std::getenv(name); });
    if (!shard.ok()) {
      print({{"--shard", 0, 0, shard.error}});
      return ExitCode::usage;
    }
    options.shard = shard.value;
  }
  SweepOutcome outcome;
  {
    CountProgress progress(isatty(STDERR_FILENO));
    options.progress = [&](std::int64_t done, std::int64_t of, std::int64_t failed) {
      progress.update(done, of, fmt::format("{} failed", failed));
    };
    outcome = run_sweep(arguments.file, options);
  }
  if (outcome.exit == ExitCode::interrupted)
    spdlog::error("interrupted after {} points; --resume goes on from there", outcome.record.points.size());
  return report(
      outcome,
      [&](const SweepPoint& point) { return point_command(outcome.record.header, point, arguments.file, arguments.set); },
      arguments.json);
}

ExitCode merge(const MergeArguments& arguments) {
  const SweepOutcome outcome = merge_sweep(arguments.parts, arguments.out);
  return report(
      outcome,
      [&](const SweepPoint& point) { return point_command(outcome.record.header, point, outcome.record.header.file); },
      arguments.json);
}

}  // namespace evenstep::app
