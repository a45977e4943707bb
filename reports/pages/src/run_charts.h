#pragma once
/// What the charts of a run's page are drawn from, as JSON (reports/pages/web/report.js). The numbers are those of
/// series.csv and summary.json: rows of the record, in its own units.

#include <span>

#include "evenstep/reports/json.h"
#include "evenstep/reports/measures.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/reports/verdict.h"

namespace evenstep::internal {

/// Null if there is nothing to draw.
Json run_charts(const RunRecord& run, std::span<const ExpectationResult> results);

}  // namespace evenstep::internal
