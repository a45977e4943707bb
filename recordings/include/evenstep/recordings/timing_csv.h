#pragma once
/// Recorded timing, with the columns `segment,kind,index,begin_ns,end_ns` (kind is visualization, step or idle) in integers.
/// There may be gaps between rows; a visualization may overlap steps (if it has its own thread); N may vary. Errors,
/// reported with their line: time going back (a step that begins before the one before it ended, an end before its begin), a
/// segment number going back, more than 10 million rows.

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

/// The same format, or a plain list of steps with the header `begin_ns,end_ns`, which becomes one segment. Steps must not
/// overlap.
TimingCsv read_timing_or_steps(const std::string& path);
TimingCsv parse_timing_or_steps(const std::string& text, const std::string& name);

}  // namespace evenstep
