#pragma once
/// The options of every command whose work can be divided into shards.

#include <atomic>
#include <optional>
#include <string>

#include "command.h"
#include "evenstep/campaigns/parts.h"

namespace evenstep::app {

struct PartArguments {
  std::string shard, out, status;
  std::optional<std::int64_t> of, threads;
  bool resume = false;

  /// Whether lines are written to a file from which another process can go on.
  bool in_parts() const { return resume || !shard.empty(); }
};

/// --shard, --of, --threads, --resume and --status. `items`: what the command calls them, "points".
void add_part_options(Command& command, PartArguments& arguments, const std::string& kind, const std::string& items);
/// --out, or runs/<name>-<kind>.
std::string folder_for(const PartArguments& arguments, const std::string& file, const std::string& kind);
/// What --shard and --of ask for. What comes from the environment is printed, so that a job's log shows it. False on an
/// error, which is then printed.
bool put_part(const PartArguments& arguments, const std::string& folder, const std::atomic<bool>& interrupted,
              PartOptions& options);
/// False, after printing why, if there was an error or a failure.
bool said_why(const PartOutcome& outcome);
/// How many points are done, of how many shards, at which rate, and the state of each.
std::string status_text(const PartsStatus& status);
/// Prints it for --status. The exit code says nothing about the points: it is 0 if the parts could be read.
ExitCode print_parts_status(const PartArguments& arguments, const std::string& kind);

}  // namespace evenstep::app
