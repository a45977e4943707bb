#pragma once
/// `evenstep compare`: the figures of runs before and after a change, and whether a threshold is exceeded
/// (docs/begin/compare.md).

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

/// A is before, B after. Runs of the same name are compared. A run whose name has no partner is compared with the one of the
/// same scenario file, if that file has exactly one run without a partner on each side. Two single runs are always a pair.
/// `allow_missing`: a run of A that B does not have exceeds no threshold; otherwise it exceeds all, because nobody can say
/// that its figures keep to them.
ComparisonRecord compare(const CompareSide& a, const CompareSide& b, const std::vector<Threshold>& thresholds,
                         bool allow_missing);

}  // namespace evenstep
