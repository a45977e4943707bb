#pragma once
/// The rows of `evenstep size --what-if`: what the maps need after a change of the timing, and what the change costs.

#include <span>
#include <vector>

#include "evenstep/campaigns/size.h"
#include "evenstep/harness/sizing.h"

namespace evenstep::internal {

/// The timing as it is, and each what-if of the options, with a second row for what a simulator that does not know the
/// future can do. `setup.end` is not used: all of a timing counts. Empty if nothing is asked for.
std::vector<SizeWhatIf> what_if_rows(const MapSetup& setup, std::span<const SegmentTiming> segments,
                                     std::span<const StrategyKind> maps, const SizeOptions& options);

}  // namespace evenstep::internal
