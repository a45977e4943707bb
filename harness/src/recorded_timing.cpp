#include "evenstep/harness/recorded_timing.h"

namespace evenstep {

std::vector<SegmentTiming> recorded_timing(const StrategyRecord& record) {
  std::vector<SegmentTiming> segments;
  segments.reserve(record.segments.size());
  std::size_t n = 0;
  for (const SegmentRow& row : record.segments) {
    SegmentTiming& segment = segments.emplace_back();
    segment.index = row.index;
    segment.begin = row.begin;
    segment.end = row.end;
    if (row.visualization) segment.visualization = Interval{(*row.visualization)[0], (*row.visualization)[1]};
    for (; n < record.steps.size() && record.steps[n].segment == row.index; ++n)
      segment.steps.push_back({record.steps[n].begin, record.steps[n].end});
  }
  return segments;
}

}  // namespace evenstep
