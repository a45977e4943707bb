#pragma once
/// stdout and stderr of the program. In a step of GitHub Actions errors and warnings become annotations, and the runner
/// takes nothing else that is printed for a command. A terminal takes nothing that a scenario contains for a command. What
/// goes into a file or a pipe is unchanged.

#include <string>

#include "evenstep/apps/workflow_commands.h"
#include "evenstep/harness/run.h"

namespace evenstep::app {

/// Whether this is a step of GitHub Actions.
bool on_github();
/// To be called before anything is printed. `program` is how this program was started, for messages that name a command.
void prepare_output(const std::string& program);
/// To be called after everything was printed: `code`, or run_failed, with a message, if stdout has not taken all of it (a
/// full disk, a closed pipe). A reader that closes the pipe is no failure, but ExitCode::pass, if it `may_stop`.
ExitCode finish_output(ExitCode code, bool may_stop);
/// Prints the annotation; nothing if this is no step of GitHub Actions.
void annotate(AnnotationLevel level, const Place& place, const std::string& title, const std::string& message);
/// Adds a table of verdicts to the job's summary, if there is one.
void add_to_job_summary(const std::vector<SummaryRow>& rows, const std::string& below);

}  // namespace evenstep::app
