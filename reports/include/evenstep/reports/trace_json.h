#pragma once
/// A run for Perfetto's viewer (ui.perfetto.dev) and chrome://tracing, in the Trace Event Format: docs/reference/metrics.md,
/// "trace.json".

#include <ostream>

#include "evenstep/reports/run_record.h"

namespace evenstep {

/// Written row by row. Times are microseconds with three digits, so no nanosecond is lost.
void trace_json(const RunRecord& run, std::ostream& out);

}  // namespace evenstep
