#pragma once
/// Which part of the program's own made a run differ from its repetition.

#include <string>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// In one sentence which foreign part answered the same otherwise, and where first; empty if it was none of them.
std::string foreign_culprit(const Scenario& scenario, const StrategyRecord& a, const StrategyRecord& b);

}  // namespace evenstep::internal
