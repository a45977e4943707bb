#pragma once
/// `evenstep sweep` and `evenstep merge`: a scenario's [sweep], every combination of its grid with every seed. Each point is
/// a run on the virtual clock whose result depends on nothing but itself, so it does not matter who runs it: threads and
/// shards give the same bytes. docs/sweep.md has the format of sweep.jsonl.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/harness/run.h"
#include "evenstep/reports/sweep_record.h"

namespace evenstep {

/// Shard I of N has the points with number % N == I - 1, so that a value that takes long burdens all of them.
struct SweepShard {
  int index = 1, of = 1;
};
/// "2/5"; or "auto": what a batch system says of itself (Slurm arrays and tasks, Open MPI, PMI, GitLab's parallel jobs,
/// Google Test's variables), which is an error where nobody says anything. `variable`: reads the environment.
Parsed<SweepShard> parse_shard(const std::string& text, const std::function<const char*(const char*)>& variable);

struct SweepOptions {
  std::vector<std::string> set;
  SweepShard shard;
  int threads = 0;                         ///< points side by side; 0: one per core
  std::optional<std::int64_t> stop_after;  ///< instead of the scenario's
  bool resume = false;
  std::string folder;  ///< for sweep.jsonl, or sweep-I-of-N.jsonl
  const std::atomic<bool>* interrupted = nullptr;
  std::function<void(std::int64_t done, std::int64_t of, std::int64_t failed)> progress;  ///< any thread, one at a time
};

struct SweepOutcome {
  ExitCode exit = ExitCode::pass;
  std::vector<Diagnostic> errors;  ///< of the scenario, or of the parts to merge: nothing was run, nothing written
  std::string failure;             ///< the sweep itself could not go on: disk, or a file that is not its own
  std::string file;                ///< where the points are
  SweepRecord record;
  SweepSummary summary;
};

/// Writes its lines in order of index to a file beside `file` that ends in ".partial", and renames it once it is complete.
/// An interrupt leaves that one for --resume, which keeps its whole lines.
///
/// stop_after = K: the result is everything up to the K-th failure by index, whoever runs it. A shard stops at its own K-th.
/// Every point before the K-th failure of all is then in some shard: a shard that ran to its end has all of its points, and
/// one that stopped did so at its K-th failure, which cannot come before the K-th of all.
/// With [sweep.find] a shard passes as such: only the merge can say what is found.
SweepOutcome run_sweep(const std::string& path, const SweepOptions& options);

/// Parts in any order; a whole sweep.jsonl is one, too. Refuses gaps and overlaps (naming points), damaged lines (naming
/// them) and parts of another build, scenario or sweep. Writes the bytes that one process would have written.
SweepOutcome merge_sweep(const std::vector<std::string>& parts, const std::string& out);

/// What is wrong with the points of a scenario's [sweep]: every combination is read, none is run.
std::vector<Diagnostic> check_sweep(const std::string& path, const std::vector<std::string>& set);

/// The one command that runs a point again; `file` as the scenario is found from here.
std::string point_command(const SweepHeader& header, const SweepPoint& point, const std::string& file,
                          const std::vector<std::string>& set = {});

/// A word for the shell, quoted where it has to be.
std::string shell_word(const std::string& word);

}  // namespace evenstep
