#include <algorithm>
#include <cmath>
#include <limits>

#include "evenstep/reports/sweep_record.h"

namespace evenstep {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void count(SweepTally& tally, SweepVerdict verdict) {
  ++(verdict == SweepVerdict::pass ? tally.passed : verdict == SweepVerdict::fail ? tally.failed : tally.errors);
}

/// By how much a limit is exceeded, as a share of the limit; for a limit of 0, the distance itself.
double excess_over(double limit, double distance) { return limit == 0 ? distance : distance / std::abs(limit); }

/// By how much a value exceeds its limits, or (negative) how far it is from them. Empty if that has no meaning (for an exact
/// value that is met).
std::optional<double> excess_of(const SweepPoint::Value& judged) {
  if (!judged.value && judged.verdict != SweepVerdict::skipped) return kInfinity;
  const bool passes = judged.verdict == SweepVerdict::pass;
  if (judged.verdict == SweepVerdict::skipped) return std::nullopt;
  if (passes && judged.min && judged.max && *judged.min == *judged.max) return std::nullopt;
  double excess = -kInfinity;
  if (judged.max) excess = std::max(excess, excess_over(*judged.max, *judged.value - *judged.max));
  if (judged.min) excess = std::max(excess, excess_over(*judged.min, *judged.min - *judged.value));
  // With expect_fail it is the other way round: the limit is exceeded if the known fault is gone.
  return (excess > 0) == passes ? -excess : excess;
}

SweepSummary::Worst worst_of(const SweepPoint& point) {
  if (point.expect.empty()) return {point, kInfinity, std::nullopt};
  SweepSummary::Worst worst{point, -kInfinity, std::nullopt};
  for (std::size_t i = 0; i < point.expect.size(); ++i) {
    const std::optional<double> excess = excess_of(point.expect[i]);
    if (excess && (*excess > worst.excess || !worst.expectation)) {
      worst.excess = *excess;
      worst.expectation = i;
    }
  }
  return worst;
}

/// The value whose failures decide the result: the next one beyond the value that is found, or the one at the safe end if no
/// value is found.
std::optional<std::size_t> deciding_value(const SweepHeader& header, const std::optional<SweepSummary::Find>& found) {
  if (!found) return std::nullopt;
  const std::size_t last = header.grid[header.find->axis].values.size() - 1;
  if (!found->value) return header.find->smallest ? last : 0;
  if (*found->value == (header.find->smallest ? 0 : last)) return std::nullopt;
  return header.find->smallest ? *found->value - 1 : *found->value + 1;
}

bool is_worse(const SweepSummary::Worst& a, const SweepSummary::Worst& b) {
  // Points that did not pass come first, however small their excess is.
  const bool a_passes = a.point.verdict == SweepVerdict::pass, b_passes = b.point.verdict == SweepVerdict::pass;
  if (a_passes != b_passes) return b_passes;
  return a.excess != b.excess ? a.excess > b.excess : a.point.index < b.point.index;
}

SweepSummary::Find find_value(const SweepHeader::Find& wanted, const std::vector<SweepTally>& tallies) {
  SweepSummary::Find found;
  const auto passes = [&](std::size_t i) { return tallies[i].runs() > 0 && tallies[i].passed == tallies[i].runs(); };
  // Starts at the safe end, which is the last value for `smallest` and the first one for `largest`.
  std::size_t steps = 0;
  const auto at = [&](std::size_t step) { return wanted.smallest ? tallies.size() - 1 - step : step; };
  while (steps < tallies.size() && passes(at(steps))) ++steps;
  if (steps > 0) found.value = at(steps - 1);
  for (std::size_t step = steps; step < tallies.size(); ++step) found.beyond += passes(at(step)) ? 1 : 0;
  found.within_gate = steps > tallies.size() - wanted.allowed;
  return found;
}

}  // namespace

const char* name_of(SweepVerdict verdict) {
  switch (verdict) {
    case SweepVerdict::pass:
      return "pass";
    case SweepVerdict::fail:
      return "fail";
    case SweepVerdict::error:
      return "error";
    case SweepVerdict::skipped:
      return "skipped";
  }
  return "error";
}

bool SweepSummary::untested() const {
  const auto lacks = [](const std::vector<std::int64_t>& points) {
    return std::find(points.begin(), points.end(), 0) != points.end();
  };
  return complete && (lacks(reached) || lacks(judged));
}

std::int64_t SweepHeader::combinations() const {
  std::int64_t product = 1;
  for (const Axis& axis : grid) product *= std::ssize(axis.values);
  return product;
}

std::uint64_t SweepHeader::seed_of(std::int64_t point) const {
  return seeds[static_cast<std::size_t>(point % std::ssize(seeds))];
}

std::size_t SweepHeader::value_of(std::int64_t point, std::size_t axis) const {
  std::int64_t rest = point / std::ssize(seeds);
  for (std::size_t later = grid.size() - 1; later > axis; --later) rest /= std::ssize(grid[later].values);
  return static_cast<std::size_t>(rest % std::ssize(grid[axis].values));
}

SweepSummarizer::SweepSummarizer(const SweepHeader& header) : header_(&header) {
  for (const SweepHeader::Axis& axis : header.grid) so_far_.values.emplace_back(axis.values.size());
  so_far_.reached.resize(header.sometimes.size());
  so_far_.judged.resize(header.expectations.size());
  worst_.resize(header.find ? header.grid[header.find->axis].values.size() : 1);
}

void SweepSummarizer::add(const SweepPoint& point) {
  for (std::size_t i = 0; i < point.reached.size(); ++i) so_far_.reached[i] += point.reached[i] ? 1 : 0;
  for (std::size_t i = 0; i < so_far_.judged.size(); ++i) {
    const bool skipped = i < point.expect.size() && point.expect[i].verdict == SweepVerdict::skipped;
    so_far_.judged[i] += skipped ? 0 : 1;
  }
  count(so_far_.all, point.verdict);
  for (std::size_t axis = 0; axis < header_->grid.size(); ++axis)
    count(so_far_.values[axis][header_->value_of(point.index, axis)], point.verdict);
  const SweepSummary::Worst worst = worst_of(point);
  if (point.verdict != SweepVerdict::pass && !header_->find && so_far_.not_passed.size() < kMostListed)
    so_far_.not_passed.push_back(worst);
  if (!worst.expectation && point.verdict == SweepVerdict::pass) return;
  std::vector<SweepSummary::Worst>& kept = worst_[header_->find ? header_->value_of(point.index, header_->find->axis) : 0];
  const auto most = static_cast<std::size_t>(header_->keep_worst);
  if (kept.size() == most && (most == 0 || !is_worse(worst, kept.back()))) return;
  kept.insert(std::upper_bound(kept.begin(), kept.end(), worst, is_worse), worst);
  if (kept.size() > most) kept.pop_back();
}

SweepSummary SweepSummarizer::summary() const {
  SweepSummary summary = so_far_;
  summary.stopped = header_->stop_after && summary.all.failed + summary.all.errors >= *header_->stop_after;
  summary.complete = !summary.stopped && summary.all.runs() == header_->points();
  if (!header_->find) {
    summary.worst = worst_.front();
    return summary;
  }
  summary.find = find_value(*header_->find, summary.values[header_->find->axis]);
  if (const std::optional<std::size_t> value = deciding_value(*header_, summary.find)) {
    summary.worst = worst_[*value];
    return summary;
  }
  // No value decides, since every value passes: the worst points of all values.
  for (const std::vector<SweepSummary::Worst>& of_value : worst_)
    summary.worst.insert(summary.worst.end(), of_value.begin(), of_value.end());
  std::sort(summary.worst.begin(), summary.worst.end(), is_worse);
  summary.worst.resize(std::min(summary.worst.size(), static_cast<std::size_t>(header_->keep_worst)));
  return summary;
}

}  // namespace evenstep
