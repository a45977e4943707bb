#pragma once
/// Compares the force that was sent with the force without delay (docs/reference/metrics.md).

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// Empty if the undelayed force was not computed.
std::map<std::string, double> undelayed_values(const DeviceRecord& device, const Rows<std::size_t>& ticks,
                                               std::optional<RealTime> stop);

}  // namespace evenstep::internal
