#include "evenstep/remap/step_cycle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "evenstep/time/digest.h"

namespace evenstep {
namespace {

constexpr double kStandsOut = 1.5;  // factor between the longest short gap and the shortest long one
constexpr double kRegular = 0.6;
constexpr double kAlike = 0.01;  // candidates whose regularities differ by less are equally regular
// At most this many gaps are shuffled, or those of 64 segments if they are more: further ones would tell nothing new.
constexpr std::size_t kShuffled = 16'384, kShuffledSegments = 64;

std::int64_t median(std::vector<std::int64_t>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The border between short and long gaps, and the factor by which the gaps on its two sides differ.
struct Border {
  std::int64_t longest_short_ns = 0;
  double rise = 0;
};

/// The candidates for the border, the greatest rise first.
std::vector<Border> candidates(const std::vector<std::int64_t>& gaps, std::int64_t run_time_ns) {
  const double blur = std::max(static_cast<double>(run_time_ns) / 4, 1.0);
  // Gaps below `least` are short whatever the others are: even a rise from 0 to them would be too small for a border.
  const auto least = static_cast<std::int64_t>((kStandsOut - 1) * blur);
  std::vector<std::int64_t> long_ones;
  std::int64_t longest_short = -1;
  for (const std::int64_t gap : gaps) {
    if (gap >= least)
      long_ones.push_back(gap);
    else
      longest_short = std::max(longest_short, gap);
  }
  if (longest_short >= 0) long_ones.push_back(longest_short);
  std::sort(long_ones.begin(), long_ones.end());
  std::vector<Border> borders;
  for (std::size_t i = 1; i < long_ones.size(); ++i) {
    const double low = static_cast<double>(long_ones[i - 1]) + blur, high = static_cast<double>(long_ones[i]) + blur;
    if (high >= kStandsOut * low) borders.push_back({long_ones[i - 1], high / low});
  }
  std::stable_sort(borders.begin(), borders.end(), [](const Border& a, const Border& b) { return a.rise > b.rise; });
  return borders;
}

/// The number of steps between neighbouring gaps longer than `border`: the N of the complete segments.
std::vector<std::int64_t> counts(std::span<const std::int64_t> gaps, std::int64_t border) {
  std::vector<std::int64_t> out;
  std::optional<std::size_t> before;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i] <= border) continue;
    if (before) out.push_back(static_cast<std::int64_t>(i - *before));
    before = i;
  }
  return out;
}

/// The regularity of the header; 0 if nothing can be said: too few segments, or every gap is long.
double regularity(std::vector<std::int64_t> steps, std::size_t gap_count) {
  if (static_cast<std::int64_t>(steps.size()) < kLeastCycleSegments || steps.size() + 1 >= gap_count) return 0;
  const std::int64_t middle = median(steps);
  double distance = 0;
  for (const std::int64_t n : steps) distance += static_cast<double>(std::abs(n - middle));
  distance /= static_cast<double>(steps.size());
  const double q = static_cast<double>(steps.size() + 1) / static_cast<double>(gap_count);
  const double m = std::ceil(std::log(0.5) / std::log1p(-q));
  const double by_chance = m - 1 / q + 2 * std::pow(1 - q, m) / q;
  return 1 - distance / by_chance;
}

struct Cut {
  std::int64_t border = 0;
  double regularity = 0;
  std::int64_t segments = 0;
};

/// The winner among the candidates; `borders` has the greatest rise first.
Cut best_cut(std::span<const std::int64_t> gaps, const std::vector<Border>& borders) {
  std::vector<Cut> cuts;
  double most = -std::numeric_limits<double>::infinity();
  for (const Border& border : borders) {
    std::vector<std::int64_t> steps = counts(gaps, border.longest_short_ns);
    const auto segments = static_cast<std::int64_t>(steps.size());
    cuts.push_back({border.longest_short_ns, regularity(std::move(steps), gaps.size()), segments});
    most = std::max(most, cuts.back().regularity);
  }
  return *std::find_if(cuts.begin(), cuts.end(), [&](const Cut& cut) { return cut.regularity >= most - kAlike; });
}

int shuffles_as_regular(std::vector<std::int64_t> gaps, const std::vector<Border>& borders, const Cut& cut) {
  const std::size_t per_segment = gaps.size() / static_cast<std::size_t>(cut.segments) + 1;
  gaps.resize(std::min(gaps.size(), std::max(kShuffled, kShuffledSegments * per_segment)));
  const double found = best_cut(gaps, borders).regularity;
  int as_regular = 0;
  for (int shuffle = 0; shuffle < kCycleShuffles; ++shuffle) {
    for (std::size_t i = gaps.size(); i > 1; --i) {
      const std::uint64_t draw = mix(static_cast<std::uint64_t>(shuffle), static_cast<std::uint64_t>(i));
      std::swap(gaps[i - 1], gaps[draw % i]);
    }
    if (best_cut(gaps, borders).regularity >= found) ++as_regular;
  }
  return as_regular;
}

void describe(const std::vector<RealTime>& begins, const std::vector<std::int64_t>& gaps, std::int64_t border,
              StepCycle& cycle) {
  std::vector<std::int64_t> pauses, periods, deviations;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i] <= border) {
      cycle.longest_gap = std::max(cycle.longest_gap, Duration{gaps[i]});
      continue;
    }
    pauses.push_back(gaps[i]);
    if (!cycle.boundaries.empty()) periods.push_back((begins[i + 1] - begins[cycle.boundaries.back()]).ns);
    cycle.boundaries.push_back(i + 1);
  }
  cycle.pause = {median(pauses)};
  cycle.period = {median(periods)};
  for (const std::int64_t period : periods) deviations.push_back(std::abs(period - cycle.period.ns));
  cycle.period_variation = static_cast<double>(median(deviations)) / static_cast<double>(cycle.period.ns);
  std::map<std::int64_t, std::int64_t> times;
  for (const std::int64_t n : counts(gaps, border)) ++times[n];
  const auto commonest =
      std::max_element(times.begin(), times.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  cycle.steps_per_segment = commonest->first;
  cycle.least_steps = times.begin()->first;
  cycle.most_steps = times.rbegin()->first;
  cycle.confidence = static_cast<double>(commonest->second) / static_cast<double>(cycle.segments);
}

StepCycle none(StepCycle cycle, std::string reason) {
  cycle.reason = std::move(reason);
  return cycle;
}

}  // namespace

CycleFinder::CycleFinder(std::size_t expected_steps) {
  begins_.reserve(expected_steps);
  gaps_ns_.reserve(expected_steps);
  run_times_ns_.reserve(expected_steps);
}

StepCycle find_cycle(std::span<const StepTimes> steps) {
  CycleFinder finder(steps.size());
  for (const StepTimes& step : steps) finder.add(step.begin, step.end);
  return finder.find();
}

StepCycle CycleFinder::find() {
  StepCycle cycle;
  if (begins_.size() < 2) return none(cycle, "fewer than two steps");
  const std::vector<std::int64_t>& gaps = gaps_ns_;
  const std::vector<Border> borders = candidates(gaps, median(run_times_ns_));
  if (borders.empty()) return none(cycle, "no pause between steps stands out from the others");
  const Cut cut = best_cut(gaps, borders);
  cycle.regularity = cut.regularity;
  cycle.segments = cut.segments;
  const bool enough = std::any_of(borders.begin(), borders.end(), [&](const Border& border) {
    return static_cast<std::int64_t>(counts(gaps, border.longest_short_ns).size()) >= kLeastCycleSegments;
  });
  if (!enough)
    return none(cycle, "fewer than " + std::to_string(kLeastCycleSegments) + " segments between the pauses that stand out");
  if (cut.regularity < kRegular) return none(cycle, "the long pauses follow no fixed number of steps");
  cycle.shuffles_as_regular = shuffles_as_regular(gaps, borders, cut);
  if (cycle.shuffles_as_regular > 0) return none(cycle, "the same gaps in another order are as regular by chance");
  cycle.found = true;
  describe(begins_, gaps, cut.border, cycle);
  return cycle;
}

}  // namespace evenstep
