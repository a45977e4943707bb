#pragma once
/// A page about a folder of runs: each with its verdict and its worst margin, and how that margin changed from run to run.

#include <optional>
#include <string>
#include <vector>

namespace evenstep {

struct IndexedRun {
  std::string name;  ///< its folder, below that of the page
  std::string link;  ///< file below the folder of the page: report.html, or what there is
  std::string scenario, file, date, commit, verdict;
  std::optional<double> margin;  ///< the least of its expectations, as a share of the limit; empty: none has a margin
  std::string margin_of;         ///< that expectation
};

/// The line that says what the page is. A file with it may be replaced by a newer one.
inline constexpr const char* kIndexKind = "index of runs";

/// Trends are over the runs of one scenario file, by date, and then by name. `command` is what makes the page again.
std::string index_page(const std::string& folder, const std::vector<IndexedRun>& runs, const std::string& command);

}  // namespace evenstep
