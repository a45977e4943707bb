#pragma once
/// Finds the repeating cycle of a simulator from nothing but the begin and end times of its steps: N steps, a long pause,
/// N steps, ... This is the time segment of the paper (section 3) as seen by an observer who cannot see the visualization.
///
/// 1. The gap before step n is g_n = max(S_n - E_{n-1}, 0). A pause is long where it stands out: gaps are sorted by
///    ln(g + s/4), s the median run time, and each rise by a factor of 1.5 or more between neighbours is a candidate for
///    the border between short and long. (s/4 makes all gaps far below a step look equal, because they do not matter.)
/// 2. A candidate cuts the steps into segments of N_k steps. If the same number of long pauses fell at random, N_k would be
///    geometric, P(N) = q (1 - q)^(N-1), where q is their share of all gaps; its mean distance from its median m is
///      D0 = m - 1/q + 2 (1 - q)^m / q,   m = ceil(ln(1/2) / ln(1 - q)).
///    regularity = 1 - (mean |N_k - median N|) / D0: 1 for a cycle, about 0 for chance, below 0 for clusters.
/// 3. The candidate with the greatest rise wins among those within 0.01 of the greatest regularity. It is a cycle if that
///    is at least 0.6, there are at least 16 complete segments, and none of 99 shuffles of the gaps is as regular.
///
/// Deterministic (the shuffles are drawn from mixed counters). A cycle of one step has no short gaps and cannot be told from
/// steps that are merely spaced out: none is found. O(n log n).

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

struct StepCycle {
  bool found = false;
  std::string reason;  ///< why there is none; empty if found

  std::vector<std::size_t> boundaries;  ///< positions of the first step after each long pause: each begins a segment
  std::int64_t segments = 0;            ///< complete ones, from one long pause to the next
  Duration period;                      ///< median T: from the begin of a segment's first step to that of the next segment
  double period_variation = 0;          ///< median |T - period| / period
  std::int64_t steps_per_segment = 0;   ///< the commonest N
  std::int64_t least_steps = 0, most_steps = 0;
  Duration pause;               ///< median long pause; pauses lie before the first step of a segment
  Duration longest_gap;         ///< the longest of the gaps that are not long pauses
  double confidence = 0;        ///< share of the segments that have the commonest N
  double regularity = 0;        ///< as defined above
  int shuffles_as_regular = 0;  ///< how many of kCycleShuffles shuffles are at least as regular
};

inline constexpr int kCycleShuffles = 99;
inline constexpr std::int64_t kLeastCycleSegments = 16;

/// find_cycle with the steps given one by one, in order of begin.
class CycleFinder {
 public:
  explicit CycleFinder(std::size_t expected_steps = 0);
  void add(RealTime begin, RealTime end) {
    if (!begins_.empty()) gaps_ns_.push_back(std::max<std::int64_t>((begin - last_end_).ns, 0));
    begins_.push_back(begin);
    run_times_ns_.push_back((end - begin).ns);
    last_end_ = end;
  }
  /// Call once, after all steps have been added.
  StepCycle find();

 private:
  std::vector<RealTime> begins_;
  std::vector<std::int64_t> gaps_ns_;  // before step n + 1
  std::vector<std::int64_t> run_times_ns_;
  RealTime last_end_;
};

/// Steps in order of begin. With fewer than two steps, no gaps that stand out or no rhythm in them, there is no cycle, and
/// `reason` says why.
StepCycle find_cycle(std::span<const StepTimes> steps);

}  // namespace evenstep
