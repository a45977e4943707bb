#include "src/kept_rows.h"

#include <algorithm>

namespace evenstep::internal {
namespace {

constexpr std::size_t kParts = 1000;
constexpr std::int64_t kAround = 3;  // segments before and after a place that matters
constexpr std::int64_t kMiddle = 6;  // segments on each side of the run's middle, where a page opens
constexpr std::size_t kPlaces = 12;  // the first late forces of each strategy that are kept; the latest always is

/// Numbers per segment if all are kept: six columns per step and two for each device, two per tick.
double numbers_per_segment(const RunRecord& run) {
  double numbers = 0, segments = 1;
  for (const StrategyRecord& strategy : run.strategies) {
    numbers += static_cast<double>(strategy.steps.size() * (6 + 2 * strategy.devices.size()));
    for (const DeviceRecord& device : strategy.devices) numbers += 2 * static_cast<double>(device.ticks.size());
    segments = std::max(segments, static_cast<double>(strategy.segments.size()));
  }
  return numbers / segments;
}

/// The segment that contains the time `at`.
std::int64_t segment_at(const StrategyRecord& strategy, RealTime at) {
  const auto after = std::upper_bound(strategy.segments.begin(), strategy.segments.end(), at,
                                      [](RealTime t, const SegmentRow& row) { return t < row.begin; });
  return after == strategy.segments.begin() ? 0 : std::prev(after)->index;
}

void add_around(std::set<std::int64_t>& segments, std::int64_t segment, std::int64_t reach) {
  for (std::int64_t s = segment - reach; s <= segment + reach; ++s) segments.insert(s);
}

void add_late(std::set<std::int64_t>& segments, const StrategyRecord& strategy) {
  std::size_t found = 0;
  const UnderrunRow* latest = nullptr;
  const auto segment_of = [&](const UnderrunRow& row) { return strategy.steps[static_cast<std::size_t>(row.step)].segment; };
  for (const UnderrunRow& row : strategy.underruns) {
    if (row.side != UnderrunRow::Side::force) continue;
    if (found++ < kPlaces) add_around(segments, segment_of(row), 1);
    if (!latest || row.lateness > latest->lateness) latest = &row;
  }
  if (latest) add_around(segments, segment_of(*latest), kAround);
}

}  // namespace

KeptSegments kept_segments(const RunRecord& run, std::span<const ExpectationResult> results, std::int64_t most_numbers) {
  KeptSegments kept;
  const double per_segment = numbers_per_segment(run);
  double segments = 0;
  for (const StrategyRecord& strategy : run.strategies)
    segments = std::max(segments, static_cast<double>(strategy.segments.size()));
  if (per_segment * segments <= static_cast<double>(most_numbers)) return kept;
  kept.every = static_cast<std::int64_t>(per_segment * segments / static_cast<double>(most_numbers)) + 1;
  for (const StrategyRecord& strategy : run.strategies) {
    add_late(kept.also, strategy);
    if (!strategy.segments.empty()) add_around(kept.also, strategy.segments[strategy.segments.size() / 2].index, kMiddle);
    for (const ExpectationResult& result : results) {
      for (const std::optional<FailurePlace>& place : {result.first, result.worst}) {
        if (place) add_around(kept.also, segment_at(strategy, place->at), kAround);
      }
    }
  }
  return kept;
}

std::vector<std::size_t> kept_rows(const std::vector<bool>& whole, std::span<const double> values) {
  std::vector<std::size_t> kept;
  const std::size_t part = std::max<std::size_t>(1, values.size() / kParts);
  for (std::size_t from = 0; from < values.size(); from += part) {
    const std::size_t to = std::min(values.size(), from + part);
    std::size_t least = from, greatest = from;
    for (std::size_t i = from; i < to; ++i) {
      if (values[i] < values[least]) least = i;
      if (values[i] > values[greatest]) greatest = i;
    }
    for (std::size_t i = from; i < to; ++i) {
      if (whole[i] || i == least || i == greatest) kept.push_back(i);
    }
  }
  return kept;
}

}  // namespace evenstep::internal
