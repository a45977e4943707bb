#pragma once
/// Which of the program's own parts made a run differ from its repetition.

#include <string>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

/// One sentence that says which foreign part answered the same question otherwise, and where first; empty if none did.
std::string foreign_culprit(const Scenario& scenario, const StrategyRecord& a, const StrategyRecord& b);

}  // namespace evenstep::internal
