#pragma once
/// Which rows of a run a page holds. Of a short run it is all of them. Of a long one it is whole segments, evenly spread and
/// around all places that matter, and of what lies between them the rows with the least and the greatest force (or position)
/// in each of a thousand parts of the run.

#include <cstdint>
#include <set>
#include <span>
#include <vector>

#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

struct KeptSegments {
  std::int64_t every = 1;       ///< one segment in this many is whole; 1: all are
  std::set<std::int64_t> also;  ///< these segments are whole too
  bool holds(std::int64_t segment) const { return every == 1 || segment % every == 0 || also.contains(segment); }
};

/// Keeps as many segments as bring the page to about `most_numbers` numbers.
KeptSegments kept_segments(const RunRecord& run, std::span<const ExpectationResult> results, std::int64_t most_numbers);

/// Which rows to keep, in order: all that are `whole`, and of the others those with extreme values. `whole` and `values`
/// have an element per row.
std::vector<std::size_t> kept_rows(const std::vector<bool>& whole, std::span<const double> values);

}  // namespace evenstep::internal
