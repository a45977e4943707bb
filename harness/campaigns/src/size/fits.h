#pragma once
#include <span>

#include "evenstep/campaigns/size_fits.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/size_record.h"

namespace evenstep::internal {

/// Judges what a program has by the needs of its map in the record, and by the rings that the map needs with the latency and
/// lead of that program: a longer latency needs larger ones.
SizeFit fit_of(const SizeFits& has, const SizeRecord& record, const MapSetup& setup,
               std::span<const SegmentTiming> segments);

}  // namespace evenstep::internal
