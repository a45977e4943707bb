#pragma once
/// The repeating cycle of a simulator, found in nothing but the begin and end times of its steps: the time segment of the
/// paper (section 3) as it looks to somebody who cannot see the visualization. N steps, a long pause, N steps, ...
///
/// 1. The gap before step n is g_n = max(S_n - E_{n-1}, 0). A pause is long where it stands out: gaps are sorted by
///    ln(g + s/4), s the median run time, and each rise by a factor of 1.5 or more between neighbours is a candidate for
///    the border between short and long. (s/4 makes gaps far below a step equal: they stop no one.)
/// 2. A candidate cuts the steps into segments of N_k steps. If as many long pauses fell anywhere, N_k would be geometric,
///    P(N) = q (1 - q)^(N-1), q their share of all gaps; its mean distance from its median m is
///      D0 = m - 1/q + 2 (1 - q)^m / q,   m = ceil(ln(1/2) / ln(1 - q)).
///    regularity = 1 - (mean |N_k - median N|) / D0: 1 for a cycle, about 0 for chance, below for clusters.
/// 3. The candidate with the greatest rise wins among those within 0.01 of the greatest regularity. It is a cycle if that
///    is at least 0.6, there are at least 16 complete segments, and none of 99 shuffles of the gaps is as regular.
///
/// Deterministic (the shuffles are counters, mixed). A cycle of one step has no short gaps and is not told from steps that
/// are merely apart: there is none. O(n log n).

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

struct StepCycle {
  bool found = false;
  std::string reason;                     ///< why there is none; empty if found

  std::vector<std::size_t> boundaries;    ///< positions of the steps that begin a segment: the first step behind each long pause
  std::int64_t segments = 0;              ///< complete ones, from one long pause to the next
  Duration period;                        ///< median T, begin of a segment's first step to that of the next one
  double period_variation = 0;            ///< median |T - period| / period
  std::int64_t steps_per_segment = 0;     ///< the commonest N
  std::int64_t least_steps = 0, most_steps = 0;
  Duration pause;                         ///< median long pause; it lies before the first step of a segment
  Duration longest_gap;                   ///< of the gaps that are not long pauses
  double confidence = 0;                  ///< share of the segments that have the commonest N
  double regularity = 0;                  ///< see above
  int shuffles_as_regular = 0;            ///< of kCycleShuffles
};

inline constexpr int kCycleShuffles = 99;
inline constexpr std::int64_t kLeastCycleSegments = 16;

/// The same, with the steps told one by one, in order of begin.
class CycleFinder {
 public:
  explicit CycleFinder(std::size_t expected_steps = 0);
  void add(RealTime begin, RealTime end) {
    if (!begins_.empty()) gaps_ns_.push_back(std::max<std::int64_t>((begin - last_end_).ns, 0));
    begins_.push_back(begin);
    run_times_ns_.push_back((end - begin).ns);
    last_end_ = end;
  }
  /// Once.
  StepCycle find();

 private:
  std::vector<RealTime> begins_;
  std::vector<std::int64_t> gaps_ns_;        // before step n + 1
  std::vector<std::int64_t> run_times_ns_;
  RealTime last_end_;
};

/// Steps in order of begin. Fewer than two steps, no gaps that stand out, no rhythm in them: not found, with the reason.
StepCycle find_cycle(std::span<const StepTimes> steps);

}  // namespace evenstep
