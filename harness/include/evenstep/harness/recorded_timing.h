#pragma once
/// The schedule that a finished run really had, in the form in which it is written to timing.csv and replayed.

#include <vector>

#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// The segments from begin to end as recorded, with their idle time. A step that had not ended when the run did is left out.
std::vector<SegmentTiming> recorded_timing(const StrategyRecord& record);

}  // namespace evenstep
