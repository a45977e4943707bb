// Any bytes as a recorded timing.
#include <algorithm>

#include "evenstep/recordings/timing_csv.h"
#include "property.h"

using namespace evenstep;
using namespace evenstep::test;

namespace {

constexpr std::int64_t kLongest_ns = 1'000'000'000'000'000;  // 1e6 s, as documented

void require_sound(const Interval& interval, const SegmentTiming& segment) {
  require(interval.begin <= interval.end, "an interval ends before it begins");
  require(segment.begin <= interval.begin && interval.end <= segment.end, "an interval is outside its segment");
}

void require_sound(const std::vector<SegmentTiming>& segments) {
  require(!segments.empty() && segments.front().begin.ns == 0, "the first segment does not begin at 0");
  RealTime last_begin{-1}, last_step_end{0};
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const SegmentTiming& segment = segments[k];
    require(segment.index == static_cast<std::int64_t>(k), "segments are not numbered from 0");
    require(segment.begin > last_begin, "a segment does not begin after the one before it");
    last_begin = segment.begin;
    require(segment.end.ns <= kLongest_ns, "a segment ends later than 1e6 s");
    if (segment.visualization) require_sound(*segment.visualization, segment);
    for (const Interval& step : segment.steps) {
      require_sound(step, segment);
      require(step.begin >= last_step_end, "two steps overlap");
      last_step_end = step.end;
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const TimingCsv csv = parse_timing_csv(std::string(reinterpret_cast<const char*>(data), size), "timing.csv");
  if (csv) require_sound(*csv);
  require_read_or_refused(csv.ok(), csv.error_or({}));
  return 0;
}
