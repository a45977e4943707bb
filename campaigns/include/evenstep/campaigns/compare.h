#pragma once
/// `evenstep compare`: the figures of runs before and after a change, and whether a threshold is exceeded (docs/compare.md).

#include <string>
#include <vector>

#include "evenstep/campaigns/summary.h"
#include "evenstep/campaigns/threshold.h"
#include "evenstep/reports/comparison_record.h"

namespace evenstep {

struct CompareSide {
  std::string given;  ///< as it was typed
  std::vector<RunSummary> runs;
};

/// A is before, B after. A run of each side is compared with the one of the same name; where names have no partner, with the
/// one of the same scenario file, if that has only one run without a partner on each side; two single runs are always a
/// pair. `allow_missing`: a run of A that B does not have breaks no threshold; otherwise it breaks all, because nobody can
/// say that none of its figures is exceeded.
ComparisonRecord compare(const CompareSide& a, const CompareSide& b, const std::vector<Threshold>& thresholds,
                         bool allow_missing);

}  // namespace evenstep
