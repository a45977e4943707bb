#pragma once
/// What `run` and `replay` print about a run.

#include <string>
#include <string_view>

#include "evenstep/harness/run.h"

namespace evenstep::app {

/// Everything but the last line. `folder` is the run folder, `reproduce` the command that runs it again. Without `verbose`:
/// a line per strategy, the expectations that do not hold, and what was suffered; with it, all expectations and how errors
/// grow.
void print_outcome(const Scenario& scenario, const RunOutcome& outcome, const std::string& folder,
                   const std::string& program, const std::string& reproduce, bool verbose);
/// The last line: "PASS", "FAIL", ...
std::string_view words(const RunOutcome& outcome);

}  // namespace evenstep::app
