#include "evenstep/harness/recorded_timing.h"

#include "evenstep/recordings/timing_csv.h"

namespace evenstep {

const SegmentTiming* RecordedSegments::next() {
  if (row_ == record_.segments.size()) return nullptr;
  const SegmentRow& row = record_.segments[row_++];
  segment_.index = row.index;
  segment_.begin = row.begin;
  segment_.end = row.end;
  segment_.visualization.reset();
  segment_.drawing = {.finishes = row.finishes, .left_out = row.left_out};
  if (row.visualization) segment_.visualization = Interval{(*row.visualization)[0], (*row.visualization)[1]};
  segment_.steps.clear();
  segment_.simulated.clear();
  for (; step_ < record_.steps.size() && record_.steps[step_].segment == row.index; ++step_) {
    const StepRow& step = record_.steps[step_];
    segment_.steps.push_back({step.begin, step.end});
    if (step.clock) segment_.simulated.push_back(*step.clock);
  }
  if (segment_.simulated.size() < segment_.steps.size()) segment_.simulated.clear();
  return &segment_;
}

std::vector<SegmentTiming> recorded_timing(const StrategyRecord& record) {
  std::vector<SegmentTiming> segments;
  segments.reserve(record.segments.size());
  RecordedSegments recorded(record);
  while (const SegmentTiming* segment = recorded.next()) segments.push_back(*segment);
  return segments;
}

void write_recorded_timing(const StrategyRecord& record, std::ostream& out) {
  const bool has_clock = !record.steps.empty() && record.steps.front().clock.has_value();
  write_timing_csv(
      out, [recorded = RecordedSegments(record)]() mutable { return recorded.next(); }, has_clock);
}

}  // namespace evenstep
