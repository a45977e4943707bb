#pragma once
/// `evenstep sweep` and `evenstep merge`: run a scenario's [sweep], that is every combination of its grid with every seed.
/// Each point is a run on the virtual clock whose result depends on nothing else, so any number of threads or shards gives
/// the same bytes. docs/timings/sweep.md has the format of sweep.jsonl.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/parts.h"
#include "evenstep/format/scenario.h"
#include "evenstep/reports/sweep_record.h"

namespace evenstep {

struct SweepOptions : PartOptions {
  std::vector<std::string> set;
  Registry registry;                       ///< the parts that the program brings along
  std::optional<std::int64_t> stop_after;  ///< overrides that of the scenario
};

struct SweepOutcome : PartOutcome {
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

/// merge_parts for sweeps, with their summary and exit code.
SweepOutcome merge_sweep(const std::vector<std::string>& parts, const std::string& out);

/// parts_status for sweeps, with what is known of the points so far; without [sweep.find].
struct SweepStatus : PartsStatus {
  SweepHeader header;
  SweepSummary summary;
};
Result<SweepStatus> sweep_status(const std::string& folder);

/// The errors in the points of a scenario's [sweep]: every combination is read, but none is run.
std::vector<Diagnostic> check_sweep(const std::string& path, const ReadOptions& options);

}  // namespace evenstep
