#pragma once
/// The schedule that a finished run really had, in the form in which it is written to timing.csv and replayed.

#include <iosfwd>
#include <vector>

#include "evenstep/reports/run_record.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// The segments of that schedule, one by one: next() gives a null pointer after the last one, and invalidates what it gave
/// before.
class RecordedSegments {
 public:
  explicit RecordedSegments(const StrategyRecord& record) : record_(record) {}
  const SegmentTiming* next();

 private:
  const StrategyRecord& record_;
  std::size_t row_ = 0, step_ = 0;
  SegmentTiming segment_;
};

/// The segments from begin to end as recorded, with their idle time. A step that had not ended when the run did is left out.
std::vector<SegmentTiming> recorded_timing(const StrategyRecord& record);
/// The same as timing.csv, one segment after the other, so that only one at a time is in memory.
void write_recorded_timing(const StrategyRecord& record, std::ostream& out);

}  // namespace evenstep
