#pragma once
/// Judges expectations by the measures of a run.

#include <string>
#include <string_view>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/case_record.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

/// One result per expectation, in the order of the file. A signal with `*` is judged by the worst of the signals it matches.
/// One of them that could have the metric and has no value is the worst: an error, as if it were named.
std::vector<ExpectationResult> judge(const Scenario& scenario, const RunRecord& run, const Metrics& metrics);

/// Whether a signal has this form; `*` stands for any single part.
bool matches(const std::string& pattern, const std::string& signal);
/// Whether a signal reaches this state of [[sometimes]]: of several that match, one is enough. A value that is not finite
/// reaches nothing.
bool reaches(const Expectation& condition, const Scenario& scenario, const Nominal& nominal, const Metrics& metrics);
/// What to do about a saturated signal.
std::string_view remedy_of(SaturationCause cause);
/// One expectation, judged by what is known: signals for which these measures have no value are left out, and it is an error
/// if none is left.
ExpectationResult judge_by(const Expectation& expectation, const Scenario& scenario, const Nominal& nominal,
                           const Metrics& metrics);

/// The expectations of a case, each judged over the cells it asks for.
std::vector<ExpectationResult> judge(const Scenario& scenario, const CaseRecord& record);

}  // namespace evenstep::internal
