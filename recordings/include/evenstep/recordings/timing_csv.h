#pragma once
/// Recorded timing: `segment,kind,index,begin_ns,end_ns` (kind visualization | step | idle), integers. Rows need not touch;
/// a visualization may overlap steps (its own thread); N may vary. An error (with its line): time going back (a step that
/// begins before the one before ended, an end before its begin), a segment number going back, more than 10 million rows.

#include <string>
#include <vector>

#include "evenstep/text/diagnostic.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

struct TimingCsv {
  std::vector<SegmentTiming> segments;     ///< times shifted so that the first begins at 0
  std::vector<Diagnostic> errors;
};
TimingCsv read_timing_csv(const std::string& path);
TimingCsv parse_timing_csv(const std::string& text, const std::string& name);

/// The same, or a bare list of steps with the header `begin_ns,end_ns`, which are one segment. Steps do not overlap.
TimingCsv read_timing_or_steps(const std::string& path);
TimingCsv parse_timing_or_steps(const std::string& text, const std::string& name);

}  // namespace evenstep
