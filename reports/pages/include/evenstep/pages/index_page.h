#pragma once
/// A page about a folder of runs: each with its verdict and its worst margin, and how that margin changed from run to run.

#include <optional>
#include <string>
#include <vector>

namespace evenstep {

struct IndexedRun {
  std::string name;  ///< its folder, below that of the page
  std::string link;  ///< file below the folder of the page: the run's report.html or summary.json
  std::string scenario, file, date, commit, verdict;
  std::optional<double> margin;  ///< the least of its expectations, as a share of the limit; empty: none has a margin
  std::string margin_of;         ///< the expectation with that margin
};

/// The line that says what the page is. A file with it may be replaced by a newer one.
inline constexpr const char* kIndexKind = "index of runs";

/// Trends are over the runs of one scenario file, in order of date, then of name. `command` makes the page again.
std::string index_page(const std::string& folder, const std::vector<IndexedRun>& runs, const std::string& command);

}  // namespace evenstep
