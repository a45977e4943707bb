#pragma once
/// What the scene would have answered without any delay: a second solver, stepped at a device's own ticks by what each of them
/// read.

#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// TickRow::undelayed_N of every device. Of a tissue, whose every step costs, only where the scenario asks for it; the other
/// tool is then where the line between its own ticks is.
void put_undelayed(const Scenario& scenario, std::vector<DeviceRecord>& devices);

}  // namespace evenstep::internal
