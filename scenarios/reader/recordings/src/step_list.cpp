#include "evenstep/recordings/step_list.h"

#include <utility>

namespace evenstep {
namespace {

/// The same steps in segments that begin at these positions; steps before the first of them are left out.
std::vector<SegmentTiming> cut_at(const std::vector<Interval>& steps, const std::vector<std::size_t>& boundaries) {
  std::vector<SegmentTiming> segments;
  segments.reserve(boundaries.size());
  for (std::size_t k = 0; k < boundaries.size(); ++k) {
    const std::size_t end = k + 1 < boundaries.size() ? boundaries[k + 1] : steps.size();
    SegmentTiming segment;
    segment.index = static_cast<std::int64_t>(k);
    segment.begin = steps[boundaries[k]].begin;
    const auto at = [&](std::size_t n) { return steps.begin() + static_cast<std::ptrdiff_t>(n); };
    segment.steps.assign(at(boundaries[k]), at(end));
    segment.end = segment.steps.back().end;
    segments.push_back(std::move(segment));
  }
  return segments;
}

}  // namespace

StepCycle cycle_of(const std::vector<SegmentTiming>& segments) {
  std::size_t count = 0;
  for (const SegmentTiming& segment : segments) count += segment.steps.size();
  CycleFinder finder(count);
  for (const SegmentTiming& segment : segments) {
    for (const Interval& step : segment.steps) finder.add(step.begin, step.end);
  }
  return finder.find();
}

CutSteps cut_steps(const std::vector<Interval>& steps, const StepCycle& cycle) {
  std::vector<std::size_t> boundaries = cycle.boundaries;
  if (!cycle.found) {
    boundaries.resize(steps.size());
    for (std::size_t n = 0; n < steps.size(); ++n) boundaries[n] = n;
  } else if (static_cast<std::int64_t>(boundaries.front()) == cycle.steps_per_segment) {
    boundaries.insert(boundaries.begin(), 0);
  }
  return {cut_at(steps, boundaries), boundaries.empty() ? 0 : static_cast<std::int64_t>(boundaries.front())};
}

}  // namespace evenstep
