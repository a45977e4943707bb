#include "part_arguments.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "commands.h"

namespace evenstep::app {
namespace {

Result<Shard> asked_shard(const PartArguments& arguments) {
  if (arguments.shard.empty() && arguments.of) return Failure("--of belongs to --shard auto");
  if (arguments.shard.empty()) return Shard{};
  std::optional<int> of;
  if (arguments.of) of = static_cast<int>(*arguments.of);
  const Result<ShardSaid> said = parse_shard(arguments.shard, of, [](const char* name) { return std::getenv(name); });
  if (!said) return Failure(said.error());
  if (!said->by.empty()) spdlog::info("shard {} of {} ({})", said->shard.index, said->shard.of, said->by);
  return said->shard;
}

/// At the rate of the whole time until now, which includes pauses.
std::string rate_of(const PartsStatus& status) {
  const std::int64_t left = status.items - status.done;
  if (!status.seconds || status.done == 0) return "";
  const double rate = static_cast<double>(status.done) / *status.seconds;
  if (left == 0) return fmt::format("{:.3g} points a second\n", rate);
  return fmt::format("{:.3g} points a second, about {:.0f} s left\n", rate, std::ceil(static_cast<double>(left) / rate));
}

}  // namespace

void add_part_options(Command& command, PartArguments& arguments, const std::string& kind, const std::string& items) {
  command.option("--shard", arguments.shard,
                 fmt::format("I/N: every N-th of the {} from the I-th on; auto: as the batch system says", items));
  command.option("--of", arguments.of, Range{1, kMostShards}, "N: how many shards there are, for --shard auto");
  command.option("--threads", arguments.threads, Range{0, 1024},
                 fmt::format("{}{} side by side; 0 (default) = one per core (results do not depend on it)",
                             kind == "study" ? "with --shard or --resume, which measure " : "", items));
  command.flag("--resume", arguments.resume, fmt::format("go on where a {} was interrupted, or start", kind));
  command.option("--status", arguments.status, "folder of the parts: how far it has come; runs nothing");
}

std::string folder_for(const PartArguments& arguments, const std::string& file, const std::string& kind) {
  if (!arguments.out.empty()) return arguments.out;
  return (default_place() / fmt::format("{}-{}", std::filesystem::path(file).stem().string(), kind)).string();
}

bool put_part(const PartArguments& arguments, const std::string& folder, const std::atomic<bool>& interrupted,
              PartOptions& options) {
  const Result<Shard> shard = asked_shard(arguments);
  if (!shard) {
    print({{"--shard", 0, 0, shard.error()}});
    return false;
  }
  options.shard = *shard;
  options.threads = static_cast<int>(arguments.threads.value_or(0));
  options.resume = arguments.resume;
  options.folder = folder;
  options.interrupted = &interrupted;
  return true;
}

bool said_why(const PartOutcome& outcome) {
  print(outcome.errors);
  if (!outcome.failure.empty()) spdlog::error("error: {}", outcome.failure);
  return outcome.errors.empty() && outcome.failure.empty();
}

std::string status_text(const PartsStatus& status) {
  std::string text = fmt::format("{} of {} points, {} of {} shards have begun\n", status.done, status.items,
                                 status.parts.size(), status.parts.front().shard.of);
  for (const PartsStatus::Part& part : status.parts) {
    text += fmt::format("shard {} of {}: {} of {} points, {} failed{}\n", part.shard.index, part.shard.of, part.done,
                        part.items, part.failed, part.ended ? ", complete" : "");
  }
  return text + rate_of(status);
}

ExitCode print_parts_status(const PartArguments& arguments, const std::string& kind) {
  const Result<PartsStatus> status = parts_status(arguments.status, kind);
  if (!status) {
    print({{"--status", 0, 0, status.error()}});
    return ExitCode::usage;
  }
  fmt::print("{}", status_text(*status));
  return ExitCode::pass;
}

}  // namespace evenstep::app
