#pragma once
/// Reads summary.json (docs/schema/summary-1.json) of runs, whoever wrote it. The files are not trusted: size and depth are
/// limited, and every value that is used is checked.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/verdict.h"
#include "evenstep/text/diagnostic.h"
#include "evenstep/time/result.h"

namespace evenstep {

inline constexpr std::int64_t kMostSummaryBytes = std::int64_t{64} << 20;
inline constexpr int kMostSummaryDepth = 16;  ///< our own have 6
inline constexpr std::size_t kMostSummaries = 10'000;

struct RunSummary {
  std::string name;       ///< its folder below the one that was given; for a list or a single run, the scenario's file
  std::string file_read;  ///< the file that it was read from
  std::string evenstep, scenario, file, clock, verdict, trace_hash, failure;
  std::string digest, date, commit;  ///< empty: null, or from an older version, which did not write them
  std::uint64_t seed = 0;
  bool real_time_granted = true;
  std::vector<ExpectationResult> expectations;
  /// signal -> metric -> value in SI base units; empty where the value was not finite or not defined.
  std::map<std::string, std::map<std::string, std::optional<double>>> metrics;
  struct Strategy {
    std::string solver, solver_device, method;
    std::vector<std::string> lacks;
  };
  std::map<std::string, Strategy> strategies;
  std::vector<std::string> left_out;
  std::vector<std::string> resolved;  ///< the lines of resolved.toml beside it; empty if there is none
};

/// The runs of one text: an object (summary.json), or a list of them (`evenstep run --json` of several files). `name` is
/// that of the text in errors.
Result<std::vector<RunSummary>, std::vector<Diagnostic>> parse_summaries(const std::string& text, const std::string& name);

struct SummariesRead {
  std::vector<RunSummary> runs;    ///< by name
  std::vector<Diagnostic> errors;  ///< of files that cannot be read as such; finding nothing is an error, too
};
/// Those of a file, of a run folder, or of all run folders below a folder (not those in folders whose name begins with a
/// dot; links are not followed).
SummariesRead read_summaries(const std::string& path);

/// How far a value is from its nearest limit, as a share of that limit: 0.1 if a tenth of it is left, negative if it does
/// not hold. Empty where there is no such share: without a value, for a limit that is 0, for an `equals`, and for what was
/// expected to fail.
std::optional<double> relative_margin(const ExpectationResult& result);

}  // namespace evenstep
