#include "evenstep/harness/trust.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "evenstep/reports/rate_bound.h"
#include "evenstep/scheduler/random.h"

namespace evenstep::internal {
namespace {

constexpr std::size_t kMostBins = 1 << 14;  // for autocorrelations, of which a long one costs the square
constexpr std::size_t kLeastBlocks = 10;    // fewer cannot show a change
constexpr std::size_t kMostBlocks = 256;
constexpr std::size_t kEdge = 8;  // a change is looked for at least an eighth from either end
constexpr int kPermutations = 999;
constexpr int kMostAsLarge = 50;        // level 5 %: 50 of 1000, with the recording itself
constexpr std::int64_t kGrains = 1000;  // of the latency
constexpr double kLeastInTail = 20;     // segments; fewer show no correlation

/// Ranks in (0, 1); equal values have the same one.
std::vector<double> ranks_of(std::span<const SegmentNeed> needs, Duration SegmentNeed::*what) {
  std::vector<std::size_t> order(needs.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return needs[a].*what < needs[b].*what; });
  std::vector<double> ranks(needs.size());
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    while (to < order.size() && needs[order[to]].*what == needs[order[from]].*what) ++to;
    for (std::size_t i = from; i < to; ++i)
      ranks[order[i]] = static_cast<double>(from + to) / (2 * static_cast<double>(order.size()));
  }
  return ranks;
}

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double variance(std::span<const double> values) {
  const double m = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - m) * (value - m);
  return sum / static_cast<double>(values.size());
}

std::vector<double> block_means(std::span<const double> values, std::size_t length) {
  std::vector<double> means(values.size() / length);
  for (std::size_t i = 0; i < means.size(); ++i) means[i] = mean(values.subspan(i * length, length));
  return means;
}

/// The largest standardised difference between the mean of the values before a place and that after it.
struct Split {
  double score = 0;
  std::size_t at = 0;  ///< the first value after it
};
Split best_split(std::span<const double> values) {
  Split best;
  const double m = mean(values), deviation = std::sqrt(variance(values)), n = static_cast<double>(values.size());
  if (deviation <= 0) return best;
  double sum = 0;
  for (std::size_t i = 0; i + values.size() / kEdge < values.size(); ++i) {
    if (i >= values.size() / kEdge && i > 0) {
      const double before = static_cast<double>(i);
      const double score = std::abs(sum) / (deviation * std::sqrt(before * (n - before) / n));
      if (score > best.score) best = {score, i};
    }
    sum += values[i] - m;
  }
  return best;
}

/// The values less the mean of their side of the best split.
std::vector<double> around_split(const std::vector<double>& values) {
  std::vector<double> out = values;
  const auto at = out.begin() + static_cast<std::ptrdiff_t>(best_split(values).at);
  for (const auto& [from, to] : {std::pair(out.begin(), at), std::pair(at, out.end())}) {
    if (from == to) continue;
    const double m = mean({from, to});
    std::for_each(from, to, [&](double& value) { value -= m; });
  }
  return out;
}

/// What is compared before and after a change: of each block, the mean and the largest rank.
std::vector<std::vector<double>> block_scores(const std::vector<std::vector<double>>& ranks, std::size_t length) {
  std::vector<std::vector<double>> scores;
  for (const std::vector<double>& one : ranks) {
    scores.push_back(block_means(one, length));
    std::vector<double> largest(scores.back().size());
    for (std::size_t i = 0; i < largest.size(); ++i)
      largest[i] = *std::max_element(one.begin() + static_cast<std::ptrdiff_t>(i * length),
                                     one.begin() + static_cast<std::ptrdiff_t>((i + 1) * length));
    scores.push_back(std::move(largest));
  }
  return scores;
}

Split best_of(const std::vector<std::vector<double>>& scores, std::span<const std::size_t> order) {
  Split best;
  std::vector<double> shuffled(order.size());
  for (const std::vector<double>& score : scores) {
    std::transform(order.begin(), order.end(), shuffled.begin(), [&](std::size_t i) { return score[i]; });
    const Split split = best_split(shuffled);
    if (split.score > best.score) best = split;
  }
  return best;
}

/// Where the blocks change, if they do: the first block after it.
std::optional<std::size_t> change_of(const std::vector<std::vector<double>>& scores) {
  std::vector<std::size_t> order(scores.front().size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const Split seen = best_of(scores, order);
  const RandomStream random(0, "size.change");
  std::uint64_t draw = 0;
  int as_large = 1;
  for (int i = 0; i < kPermutations && as_large <= kMostAsLarge; ++i) {
    for (std::size_t j = order.size(); j > 1; --j) std::swap(order[j - 1], order[random.below(draw++, j)]);
    as_large += best_of(scores, order).score >= seen.score ? 1 : 0;
  }
  if (as_large > kMostAsLarge) return std::nullopt;
  return seen.at;
}

std::vector<std::vector<double>> ranks_of(std::span<const SegmentNeed> needs) {
  return {ranks_of(needs, &SegmentNeed::lead), ranks_of(needs, &SegmentNeed::delay)};
}

double alike_in_tails(const std::vector<std::vector<double>>& ranks) {
  double alike = 1;
  for (const std::vector<double>& one : ranks) {
    const auto n = static_cast<double>(one.size());
    for (const double share : {std::max(0.1, std::min(kLeastInTail / n, 0.5)), 0.02}) {
      if (share * n < kLeastInTail && share < 0.1) continue;
      std::vector<double> in_tail(one.size());
      std::transform(one.begin(), one.end(), in_tail.begin(), [&](double rank) { return rank > 1 - share ? 1.0 : 0.0; });
      alike = std::max(alike, dispersion(in_tail));
    }
  }
  return alike;
}

}  // namespace

double dispersion(std::span<const double> values) {
  const double all = variance(values);
  if (all <= 0) return 1;
  const std::size_t width = (values.size() + kMostBins - 1) / kMostBins;
  std::vector<double> bins = block_means(values, width);
  const double m = mean(bins), within = variance(bins);
  if (within <= 0) return 1;
  for (double& bin : bins) bin -= m;
  const auto correlation = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t i = lag; i < bins.size(); ++i) sum += bins[i] * bins[i - lag];
    return sum / (static_cast<double>(bins.size()) * within);
  };
  double sum = -1, least = 2;
  for (std::size_t lag = 0; lag + 1 < bins.size() / 4; lag += 2) {
    least = std::min(least, correlation(lag) + correlation(lag + 1));
    if (least <= 0) break;
    sum += 2 * least;
  }
  return std::max(sum * static_cast<double>(width) * within / all, 1.0);
}

std::vector<SegmentNeed> rounded_up(std::span<const SegmentNeed> needs) {
  std::vector<SegmentNeed> out(needs.begin(), needs.end());
  if (out.empty()) return out;
  Duration lead = out.front().lead, delay = out.front().delay;
  for (const SegmentNeed& need : out) {
    lead = std::max(lead, need.lead);
    delay = std::max(delay, need.delay);
  }
  const std::int64_t grain = std::max<std::int64_t>((lead + delay).ns / kGrains, 1);
  const auto round = [&](Duration& need) {  // needs may be negative
    const std::int64_t over = (need.ns % grain + grain) % grain;
    if (over > 0) need.ns += grain - over;
  };
  for (SegmentNeed& need : out) {
    round(need.lead);
    round(need.delay);
  }
  return out;
}

SizeTrust trust_in(std::span<const SegmentNeed> needs) {
  SizeTrust trust;
  trust.segments = std::ssize(needs);
  if (needs.empty()) return trust;
  const std::vector<std::vector<double>> ranks = ranks_of(rounded_up(needs));
  trust.alike = alike_in_tails(ranks);
  double within = 1;
  for (const std::vector<double>& one : ranks) within = std::max(within, dispersion(around_split(one)));
  const std::size_t length = std::max(static_cast<std::size_t>(std::ceil(within > 1 ? 3 * within : 1)),
                                      (needs.size() + kMostBlocks - 1) / kMostBlocks);
  trust.block = static_cast<std::int64_t>(length);
  trust.tested = needs.size() / length >= kLeastBlocks;
  if (!trust.tested) return trust;
  const std::optional<std::size_t> block = change_of(block_scores(ranks, length));
  if (!block) return trust;
  const std::size_t first = *block * length;
  trust.change = SizeTrust::Change{static_cast<std::int64_t>(first), needs[first].begin};
  return trust;
}

double alike_segments(std::span<const SegmentNeed> needs) { return needs.empty() ? 1 : alike_in_tails(ranks_of(needs)); }

double chosen_rate_at_most(std::int64_t underruns, std::int64_t segments, double alike, double confidence) {
  const auto n = static_cast<std::int64_t>(static_cast<double>(segments) / alike);
  const auto k = static_cast<std::int64_t>(std::ceil(static_cast<double>(underruns) / alike));
  return k + 1 >= n ? 1 : rate_at_most(k + 1, n, 1 - (1 - confidence) / static_cast<double>(k + 1));
}

std::int64_t most_chosen_underruns(double rate, double confidence, std::int64_t segments, double alike) {
  std::int64_t fine = -1, too_many = segments;  // the bound grows with the underruns, and is 1 where all have one
  while (too_many - fine > 1) {
    const std::int64_t middle = fine + (too_many - fine) / 2;
    (chosen_rate_at_most(middle, segments, alike, confidence) <= rate ? fine : too_many) = middle;
  }
  return fine;
}

std::int64_t chosen_segments_needed(double rate, double confidence, double alike) {
  std::int64_t few = 1, enough = 2;
  while (chosen_rate_at_most(0, enough, alike, confidence) > rate) enough *= 2;
  while (enough - few > 1) {
    const std::int64_t middle = few + (enough - few) / 2;
    (chosen_rate_at_most(0, middle, alike, confidence) <= rate ? enough : few) = middle;
  }
  return enough;
}

}  // namespace evenstep::internal
