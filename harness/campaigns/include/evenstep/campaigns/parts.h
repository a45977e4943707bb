#pragma once
/// Work in shards: what `evenstep sweep`, `study`, `size` and `catalogue` have in common. Each is a list of items that
/// depend on nothing but the scenario, the program and their number. A shard writes a line for each of its items, and
/// `evenstep merge` joins the files of all shards. docs/timings/sweep.md has the format of the files.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evenstep/harness/run.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep {

/// Shard I of N has the items with number % N == I - 1, so that all shards share the load of a value that takes long.
struct Shard {
  int index = 1, of = 1;
};
inline constexpr int kMostShards = 1'000'000;
struct ShardSaid {
  Shard shard;
  std::string by;  ///< for "auto": the variables that gave it, with their values
};
/// Parses "2/5", or "auto" for the shard that a batch system gives in the environment. `of` is how many shards there are; it
/// must be given where jobs are numbered (Slurm arrays, indexed jobs of Kubernetes, GNU parallel), since any of them may be
/// submitted again alone, and otherwise must agree with the environment (Open MPI, PMI, Slurm steps, Google Test's
/// variables, GitLab's parallel jobs). Variables that contradict each other or `of` are errors. `variable` reads the
/// environment.
Result<ShardSaid> parse_shard(const std::string& text, std::optional<int> of,
                              const std::function<const char*(const char*)>& variable);

/// Which part of the work is done, and how.
struct PartOptions {
  Shard shard;
  int threads = 0;  ///< how many items at the same time; 0: one per core. Timed items run one by one
  bool resume = false;
  std::string folder;  ///< for KIND.jsonl, or KIND-I-of-N.jsonl
  /// If not empty: a file with all lines, whatever its name. The lines are read and nothing is run; if one is missing, that
  /// is a failure.
  std::string complete_file;
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::int64_t done, std::int64_t of, std::int64_t failed)> progress;  ///< any thread, one at a time
};

/// The result of a part, or of a merge.
struct PartOutcome {
  ExitCode exit = ExitCode::pass;
  std::vector<Diagnostic> errors;  ///< errors of the scenario or of the parts to merge; then nothing was run or written
  std::string failure;             ///< why it could not go on: disk, or a file of other work
  std::string file;                ///< where the lines are
  std::int64_t items = 0, done = 0;
};

/// "sweep", "study", "size" or "catalogue": what a part is of, by its first line; empty if that cannot be read.
std::string kind_of_part(const std::string& file);

/// What the lines of a file belong to, and what its shards were asked for: all that their own command needs to give the
/// results.
struct PartSubject {
  std::string kind, file;  ///< `file`: the scenario, as it was given to a shard
  std::vector<std::string> set;
  std::vector<std::string> files;   ///< of a catalogue: its scenarios, also those that were left out
  bool long_ones = false;           ///< of a catalogue
  double rate = 0, confidence = 0;  ///< of a sizing
  std::string seeds;                ///< of a sizing
  bool other_maps = false;          ///< of a sizing
};
/// Read from the first line of a file. The error says what is wrong with that line.
Result<PartSubject> subject_of_part(const std::string& file);

/// Merges parts of any kind, in any order; a complete file may be one of them. Refuses gaps (naming the items and the
/// shards) and overlaps, damaged lines (naming them), and parts of another kind, build, scenario or list of items. Writes
/// the lines that a single process would have written. Reads the parts side by side, so the memory it takes does not grow
/// with their lines.
PartOutcome merge_parts(const std::vector<std::string>& parts, const std::string& out);

/// How far the shards that other processes run have come, by the parts in a folder as they are now.
struct PartsStatus {
  struct Part {
    Shard shard;
    std::int64_t items = 0;  ///< what it has to do, if nothing ends it before
    std::int64_t done = 0, failed = 0;
    bool ended = false;
  };
  std::vector<Part> parts;  ///< by their shards; those that have not begun are not among them
  std::int64_t items = 0, done = 0;
  std::optional<double> seconds;  ///< from the first file to the last line; empty if the file system does not say
};
/// Errors: no folder, no parts of that kind in it, a damaged line, or one of other work or of another number of shards, with
/// the place.
Result<PartsStatus> parts_status(const std::string& folder, std::string_view kind);

}  // namespace evenstep
