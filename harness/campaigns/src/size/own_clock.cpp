#include "own_clock.h"

#include <algorithm>
#include <optional>

namespace evenstep::internal {

SizeClock follow_clock(std::vector<SegmentTiming>& segments, Rate step_rate) {
  const bool given = has_clock(segments);
  const std::int64_t size_ns = instant_ns(step_rate, 1);
  SizeClock clock{.step = {size_ns}, .pace = {.step_s = period_s(step_rate)}};
  std::int64_t done = 0, frames = 0;
  std::optional<std::int64_t> least_ns, before_ns;  // of the frames so far; of the last one
  std::int64_t most_ns = INT64_MIN;
  for (SegmentTiming& segment : segments) {
    clock.pace.add_segment({segment.begin, segment.end}, segment.steps);
    if (segment.steps.empty()) continue;
    const std::int64_t count = std::ssize(segment.steps);
    if (!given) {
      const std::int64_t behind_ns = segment.begin.ns - sim_time(step_rate, done + count).ns;
      if (least_ns && behind_ns > *least_ns + 2 * size_ns && behind_ns > *before_ns + size_ns) {
        const std::int64_t dropped = (behind_ns - *least_ns) / size_ns;
        done += dropped;
        clock.dropped += dropped;
        ++clock.drops;
      }
      for (std::int64_t i = 0; i < count; ++i) segment.simulated.push_back(sim_time(step_rate, done++));
    }
    const std::int64_t behind_ns = segment.begin.ns - segment.simulated.back().ns - size_ns;
    before_ns = behind_ns;
    least_ns = std::min(least_ns.value_or(behind_ns), behind_ns);
    most_ns = std::max(most_ns, behind_ns);
    ++frames;
  }
  if (!least_ns) return clock;
  clock.range_steps = static_cast<double>(most_ns - *least_ns) / static_cast<double>(size_ns);
  clock.follows = clock.range_steps <= 2 && 10 * clock.drops <= frames;
  if (!given && !clock.follows)
    for (SegmentTiming& segment : segments) segment.simulated.clear();
  return clock;
}

}  // namespace evenstep::internal
