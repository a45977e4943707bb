#include "evenstep/scheduler/foreign_timing.h"

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>

namespace evenstep {
namespace {

/// The latest time allowed, so that sums of a few times are far from overflowing.
constexpr RealTime kLatest{4'000'000'000'000'000'000};

std::string at(RealTime time) { return std::to_string(time.ns) + " ns"; }

/// What is wrong with a segment, given that the segment before it began at `before` and the last step ended at `steps_end`.
std::optional<std::string> fault_of(const SegmentTiming& segment, std::optional<RealTime> before, RealTime steps_end) {
  if (!before && segment.begin != RealTime{0})
    return "begins at " + at(segment.begin) + ", and the first must begin at 0 ns";
  if (before && segment.begin <= *before)
    return "begins at " + at(segment.begin) + ", not after the one before it at " + at(*before);
  RealTime last = segment.begin;
  const auto piece = [&](const char* what, const Interval& interval, RealTime earliest) -> std::optional<std::string> {
    if (interval.begin < earliest)
      return std::string(what) + " begins at " + at(interval.begin) + ", before " + at(earliest);
    if (interval.end < interval.begin)
      return std::string(what) + " ends at " + at(interval.end) + ", before it begins at " + at(interval.begin);
    last = std::max(last, interval.end);
    return std::nullopt;
  };
  if (segment.visualization) {
    if (auto fault = piece("its visualization", *segment.visualization, segment.begin)) return fault;
  }
  for (const Interval& step : segment.steps) {
    if (auto fault = piece("a step", step, std::max(segment.begin, steps_end))) return fault;
    steps_end = step.end;
  }
  if (!segment.simulated.empty() && segment.simulated.size() != segment.steps.size())
    return "has " + std::to_string(segment.simulated.size()) + " simulation times for " +
           std::to_string(segment.steps.size()) + " steps";
  if (segment.end < last) return "ends at " + at(segment.end) + ", before its last piece at " + at(last);
  if (segment.end > kLatest) return "ends at " + at(segment.end) + ", beyond " + at(kLatest);
  return std::nullopt;
}

auto parts_of(const SegmentTiming& segment) {
  const auto seen = segment.visualization.value_or(Interval{});
  return std::tuple(segment.begin, segment.end, segment.visualization.has_value(), seen.begin, seen.end, segment.concurrent,
                    segment.steps.size());
}

bool same(const SegmentTiming& a, const SegmentTiming& b) {
  return parts_of(a) == parts_of(b) &&
         std::equal(a.steps.begin(), a.steps.end(), b.steps.begin(),
                    [](const Interval& x, const Interval& y) { return x.begin == y.begin && x.end == y.end; });
}

}  // namespace

Result<std::vector<SegmentTiming>, std::string> draw_timing(StepTiming& source, RealTime end) {
  std::vector<SegmentTiming> drawn;
  std::size_t pieces = 0, steps = 0;
  RealTime steps_end{0};
  for (;;) {
    SegmentTiming segment;
    if (!source.next(segment)) break;
    const std::optional<RealTime> before = drawn.empty() ? std::nullopt : std::optional(drawn.back().begin);
    if (const auto fault = fault_of(segment, before, steps_end))
      return Failure("segment " + std::to_string(drawn.size()) + " " + *fault);
    if (segment.begin >= end) break;
    segment.index = static_cast<std::int64_t>(drawn.size());
    if (!segment.steps.empty()) steps_end = segment.steps.back().end;
    steps += segment.steps.size();
    pieces += segment.steps.size() + 1;
    if (pieces > kMostDrawnPieces)
      return Failure("it has more than " + std::to_string(kMostDrawnPieces) + " segments and steps before " + at(end));
    drawn.push_back(std::move(segment));
  }
  if (steps == 0 || drawn.back().end <= RealTime{0})
    return Failure(std::string("it has no step, so there is nothing to run"));
  return drawn;
}

std::int64_t first_unequal(const std::vector<SegmentTiming>& a, const std::vector<SegmentTiming>& b) {
  const std::size_t common = std::min(a.size(), b.size());
  for (std::size_t k = 0; k < common; ++k) {
    if (!same(a[k], b[k])) return static_cast<std::int64_t>(k);
  }
  return a.size() == b.size() ? -1 : static_cast<std::int64_t>(common);
}

}  // namespace evenstep
