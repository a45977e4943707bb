#pragma once
/// `evenstep sweep` and `evenstep merge`: run a scenario's [sweep], that is every combination of its grid with every seed.
/// Each point is a run on the virtual clock whose result depends on nothing else, so any number of threads or shards gives
/// the same bytes. docs/sweep.md has the format of sweep.jsonl.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/harness/run.h"
#include "evenstep/reports/sweep_record.h"

namespace evenstep {

/// Shard I of N has the points with number % N == I - 1, so that all shards share the load of a value that takes long.
struct SweepShard {
  int index = 1, of = 1;
};
inline constexpr int kMostShards = 1'000'000;
struct ShardSaid {
  SweepShard shard;
  std::string by;  ///< of "auto": the variables that say it, with their values
};
/// Parses "2/5", or "auto" for the shard that a batch system gives in the environment. `of` is how many shards there are; it
/// must be given where jobs are numbered (Slurm arrays, indexed jobs of Kubernetes, GNU parallel), since any of them may be
/// submitted again alone, and else must agree (Open MPI, PMI, Slurm steps, Google Test's variables, GitLab's parallel jobs).
/// Variables that contradict each other or `of` are errors. `variable` reads the environment.
Result<ShardSaid> parse_shard(const std::string& text, std::optional<int> of,
                              const std::function<const char*(const char*)>& variable);

struct SweepOptions {
  std::vector<std::string> set;
  Registry registry;  ///< the parts that the program brings along
  SweepShard shard;
  int threads = 0;                         ///< how many points run at the same time; 0: one per core
  std::optional<std::int64_t> stop_after;  ///< overrides that of the scenario
  bool resume = false;
  std::string folder;  ///< for sweep.jsonl, or sweep-I-of-N.jsonl
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::int64_t done, std::int64_t of, std::int64_t failed)> progress;  ///< any thread, one at a time
};

struct SweepOutcome {
  ExitCode exit = ExitCode::pass;
  std::vector<Diagnostic> errors;  ///< errors of the scenario or of the parts to merge; then nothing was run or written
  std::string failure;             ///< why the sweep itself could not go on: disk, or a file of another sweep
  std::string file;                ///< where the points are
  SweepHeader header;
  SweepSummary summary;
};

/// Writes its lines in order of index to a file beside `file` that ends in ".partial", and renames it when it is complete.
/// If it is interrupted, that file remains for --resume, which keeps its complete lines.
///
/// stop_after = K: the result is everything up to the K-th failure by index, however the sweep is divided. A shard stops at
/// its own K-th failure. Every point before the K-th failure of the whole sweep is then in some shard: a shard that ran to
/// its end has all of its points, and one that stopped did so at its K-th failure, which cannot come before the K-th of all.
/// With [sweep.find] a single shard always passes: only the merge can tell what is found.
SweepOutcome run_sweep(const std::string& path, const SweepOptions& options);

/// Merges parts, in any order; a complete sweep.jsonl may be one of them. Refuses gaps (naming the points and the shards)
/// and overlaps, damaged lines (naming them) and parts of another build, scenario or sweep. Writes the bytes that a single
/// process would have written. Reads the parts side by side, so the memory it takes does not grow with their lines.
SweepOutcome merge_sweep(const std::vector<std::string>& parts, const std::string& out);

/// How far a sweep has come that other processes run, from the parts in a folder as they are now.
struct SweepStatus {
  SweepHeader header;
  SweepSummary summary;  ///< of the points so far; without `find`
  struct Part {
    SweepShard shard;
    std::int64_t points = 0;  ///< what it has to run, if stop_after does not end it
    std::int64_t done = 0, failed = 0;
    bool ended = false;
  };
  std::vector<Part> parts;        ///< by their shards; those that have not begun are not among them
  std::optional<double> seconds;  ///< from the first file to the last line; nothing if the file system does not say
};
/// Errors: no folder, no parts in it, a damaged line, or one of another sweep, with the place.
Result<SweepStatus> sweep_status(const std::string& folder);

/// The errors in the points of a scenario's [sweep]: every combination is read, but none is run.
std::vector<Diagnostic> check_sweep(const std::string& path, const ReadOptions& options);

}  // namespace evenstep
