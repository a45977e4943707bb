#pragma once
/// Recorded timing, with the columns `segment,kind,index,begin_ns,end_ns` (kind is segment, visualization, step or idle) in
/// integers. A segment begins with the first of its visualization and steps, unless a row of kind `segment` says from when
/// to when it lasts: where nothing begins with it, or nothing is in it. There may be gaps between rows; a visualization may
/// overlap steps (if it has its own thread); the number of steps may vary. Errors, reported with their line: time going back
/// (a step that begins before the previous one ended, an end before its begin), a segment number going back, more than 10
/// million rows. Times may be negative, up to 4e18 ns either way.
///
/// A sixth column `simulated_ns` says for each step what the loop's own simulation time is when it begins
/// (SegmentTiming::simulated); it does not go back. In all other rows that cell is empty.

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "evenstep/scheduler/step_timing.h"
#include "evenstep/text/diagnostic.h"
#include "evenstep/time/result.h"

namespace evenstep {

/// Times are shifted so that the first segment begins at 0.
using TimingCsv = Result<std::vector<SegmentTiming>, std::vector<Diagnostic>>;
TimingCsv read_timing_csv(const std::string& path);
TimingCsv parse_timing_csv(const std::string& text, const std::string& name);

/// The pieces of each segment are in order of their begin, its idle rest last. Reading the text gives the segments again,
/// shifted to begin at 0.
std::string format_timing_csv(const std::vector<SegmentTiming>& segments);
/// The same for segments that `next` hands over one by one; a null pointer ends them.
/// `with_simulated`: with the column simulated_ns.
void write_timing_csv(std::ostream& out, const std::function<const SegmentTiming*()>& next, bool with_simulated = false);

/// Of a loop that keeps its own time: the median of the differences of t(n) from step to step, because where time was
/// dropped they are longer. Otherwise 0.
Duration usual_step_size(const std::vector<SegmentTiming>& segments);

/// The same format, or a plain list of steps with the header `begin_ns,end_ns`, which becomes one segment. Steps must not
/// overlap.
TimingCsv read_timing_or_steps(const std::string& path);
TimingCsv parse_timing_or_steps(const std::string& text, const std::string& name);

}  // namespace evenstep
