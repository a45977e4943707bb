#pragma once
/// stdout and stderr of the program. In a step of GitHub Actions errors and warnings are annotations there, and nothing else
/// that is printed is taken for a command by its runner. On a terminal nothing that a scenario contains is a command for it.
/// Into a file or a pipe goes what is printed, as it is.

#include <string>

#include "evenstep/apps/workflow_commands.h"

namespace evenstep::app {

/// Whether this is a step of GitHub Actions.
bool on_github();
/// To be called before anything is printed. `program` is how this program was started, for messages that name a command.
void prepare_output(const std::string& program);
/// Prints the annotation; nothing if this is no step of GitHub Actions.
void annotate(AnnotationLevel level, const Place& place, const std::string& title, const std::string& message);
/// Adds a table of verdicts to the job's summary, if there is one.
void add_to_job_summary(const std::vector<SummaryRow>& rows, const std::string& below);

}  // namespace evenstep::app
