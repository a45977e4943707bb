#pragma once
/// Measures of the signal "closed_loop.<device>.<strategy>": docs/reference/metrics.md.

#include <map>
#include <string>

#include "evenstep/reports/measures.h"
#include "src/judged.h"

namespace evenstep::internal {

std::map<std::string, double> closed_loop_values(const RunRecord& run, const DeviceRecord& device);

}  // namespace evenstep::internal
