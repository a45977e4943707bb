#pragma once
/// report.html of what many runs have found: a sweep, a study, the sizing of a recording. The numbers are the same as in
/// their text and JSON. `reproduce` is the command that gives the same results again. docs/begin/report.md says what each
/// section shows.

#include <string>

#include "evenstep/reports/advice_record.h"
#include "evenstep/reports/felt_study_record.h"
#include "evenstep/reports/size_record.h"
#include "evenstep/reports/stiffness_limits.h"
#include "evenstep/reports/study_record.h"
#include "evenstep/reports/sweep_record.h"

namespace evenstep {

/// `verdict`: "pass", "fail" or "error"; `command` gives the command that runs a point again.
std::string sweep_page(const SweepHeader& header, const SweepSummary& summary, const SweepCommand& command,
                       const std::string& verdict, const std::string& reproduce);
std::string study_page(const StudyRecord& study, const std::string& reproduce);
std::string felt_study_page(const FeltStudyRecord& study, const std::string& reproduce);
std::string stiffness_page(const StiffnessLimits& study, const std::string& reproduce);
std::string size_page(const SizeRecord& record, const std::string& reproduce);
std::string advice_page(const AdviceRecord& record, const std::string& reproduce);

}  // namespace evenstep
