#pragma once
/// What a step of GitHub Actions says about one run.

#include <string>

#include "evenstep/apps/workflow_commands.h"
#include "evenstep/harness/run.h"

namespace evenstep::app {

/// An annotation for each expectation that does not hold, at its line, and for a run that has no verdict for another reason.
/// `file` is the scenario, `words` its verdict in words, `again` the command that runs it again.
void annotate_run(const std::string& file, const RunOutcome& outcome, std::string_view words, const std::string& again);
/// Its row in the job's summary. The note is what failed first, or how many expectations hold.
SummaryRow summary_row(const std::string& file, const RunOutcome& outcome, std::string_view words);

}  // namespace evenstep::app
