#pragma once
/// How a size does on what it has not seen (rolling origins: Tashman, Int. J. Forecasting 16, 2000). The segments are cut
/// into six parts of as many segments. The first 1, 2, ..., 5 of them are sized together, and the part after them is played
/// with that lead and latency. So each part but the first is played once, and what is played is always as long.
///
/// The maps do not know the future, and what a segment needs does not depend on lead and latency. So all of it follows from
/// the needs of the whole schedule, by prefix maxima.

#include <cstdint>
#include <span>
#include <vector>

#include "evenstep/reports/size_record.h"
#include "rate.h"

namespace evenstep::internal {

/// Empty with fewer than kLeastUnseen segments (reports/size_record.h).
std::vector<SizeUnseen> play_unseen(std::span<const SegmentNeed> needs);

}  // namespace evenstep::internal
