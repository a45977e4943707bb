#pragma once
/// The run folder: written beside its place and renamed into it, so that nobody ever sees half of one. An older run folder
/// in its place is replaced; any other folder is left alone and the write is refused.

#include <string>

#include "evenstep/harness/run.h"

namespace evenstep {

/// Whether `folder` can be written, before a long run is spent on it. Empty, or the reason with the remedy.
std::string run_folder_objection(const std::string& folder);
/// Empty, or what went wrong.
std::string write_run_folder(const std::string& folder, const Scenario& scenario, const RunOutcome& outcome,
                             const std::string& reproduce);

/// The text of summary.json.
std::string summary_of(const RunOutcome& outcome);

}  // namespace evenstep
