#pragma once
/// What saturated each judged sample of a signal (reports/saturation.h).

#include <span>
#include <vector>

#include "evenstep/reports/saturation.h"

namespace evenstep::internal {

/// The causes for each of `steps` or `ticks`, which are the judged ones.
std::vector<SaturationCauses> saturation_of_steps(const StrategyRecord& strategy, const DeviceRecord& device,
                                                  std::span<const std::size_t> steps);
std::vector<SaturationCauses> saturation_of_ticks(const StrategyRecord& strategy, const DeviceRecord& device,
                                                  std::span<const std::size_t> ticks);

}  // namespace evenstep::internal
