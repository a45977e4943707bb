#pragma once
/// The force that the scene would have given without any delay: from a second solver that makes a step at each tick of a
/// device, with the position that the tick read.

#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// Sets TickRow::undelayed_N of every device. For a tissue, whose steps are expensive, only if the scenario asks for it; the
/// other tool's position is then interpolated between its own ticks.
void put_undelayed(const Scenario& scenario, std::vector<DeviceRecord>& devices);

}  // namespace evenstep::internal
