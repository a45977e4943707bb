#pragma once
/// Expectations against measures.

#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/case_record.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

/// One result per expectation, in file order. A signal with `*` is judged by the worst of those it matches.
std::vector<ExpectationResult> judge(const Scenario& scenario, const RunRecord& run, const Metrics& metrics);

/// Of a case: each over the cells it asks for.
std::vector<ExpectationResult> judge(const Scenario& scenario, const CaseRecord& record);

}  // namespace evenstep::internal
