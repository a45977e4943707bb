#pragma once
/// report.html of a run: the verdict and the command to paste, expectations with margins, the figures with zoom, every
/// segment step by step, buffers, errors over the run, what a live run has in addition, and the scenario with its failing
/// lines marked. docs/begin/report.md says what each section shows.

#include <span>
#include <string>
#include <vector>

#include "evenstep/reports/case_record.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

/// A file that is shown, as it was when the run began.
struct SourceText {
  std::string file, text;
};

struct RunPage {
  const RunRecord& run;
  const Metrics& metrics;
  std::span<const ExpectationResult> results;
  const CaseRecord* case_record = nullptr;  ///< of a scenario with a [case]
  std::string version, verdict;
  std::vector<std::string> suffered;  ///< what it suffered and nothing asserts
  std::string failure, remedy;        ///< of a run that stopped
  std::string reproduce;              ///< the command that runs it again
  std::string study_svg;              ///< error against cost, of a study of this scenario; empty: there is none
  std::vector<SourceText> sources;
};

std::string run_page(const RunPage& page);

}  // namespace evenstep
