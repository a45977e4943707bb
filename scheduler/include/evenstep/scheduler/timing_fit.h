#pragma once
/// Derives a programmed timing from a recording: each part of ProgrammedTiming is estimated by itself and given together
/// with the evidence for it. The estimates are robust (medians, trimmed means), because a recording contains a cold start;
/// its last segment is left out, because it may be unfinished. Whatever the models cannot express is lost. Whether that
/// matters is for the caller to find out (campaigns/fit_report.h compares the latencies that recording and fit need).

#include <span>
#include <string>
#include <vector>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// A duration that varies: log-normal about `mean`, after everything else that is known about it has been removed.
struct FittedLength {
  std::int64_t count = 0;
  double median_ns = 0;
  double mean_ns = 0;           ///< mean of the values within 5 deviations of the median (of their logarithms)
  double variation = 0;         ///< coefficient of variation, from the median absolute deviation of the logarithms
  double distance = 0;          ///< Kolmogorov distance to that log-normal
  double half_width = 0;        ///< of the uniform law with the same 5 % and 95 % quantiles, over the mean
  double uniform_distance = 0;  ///< Kolmogorov distance to that law
  /// Whether the uniform law is the nearer one, and less than 1.63 / sqrt(count) away, as are 99 % of its own samples.
  bool is_uniform() const;
};

/// An estimate and its standard error.
struct FittedNumber {
  double value = 0;
  double error = 0;
};

struct TimingFit {
  ProgrammedTiming timing;  ///< the proposal; seed 1

  std::int64_t segments = 0;  ///< how many were used
  double seconds = 0;         ///< when the last of them begins
  /// Proposed in `timing` if one of them is 4 errors from 0 and amounts to 2 %, and the two agree within 3 errors.
  FittedNumber visualization_drift_per_s, step_drift_per_s;
  FittedLength visualization;            ///< without drift, hitches, regimes and merged visualizations
  std::int64_t dropped = 0, merged = 0;  ///< number of segments with a dropped or a merged visualization
  std::int64_t hitches = 0;              ///< visualizations alike in length at equal intervals, if `timing` has a hitch
  double lag_1 = 0;                      ///< correlation of neighbouring visualizations, before regimes are removed
  double regime_separation = 0;          ///< distance of the two levels, in deviations within a level; 0: one level
  double slow_share = 0;                 ///< if there are two levels: the share of segments at the slower one

  int least_steps = 0, most_steps = 0;
  double mean_steps = 0;
  FittedLength step;              ///< of the steps that are neither the first after a visualization nor hit
  FittedNumber first_step;        ///< proposed in `timing` if it is 3 errors and 2 % above 0
  FittedNumber slowdown{1, 0};    ///< concurrent: factor on steps that begin beside a visualization
  double work_s = 0;              ///< total time of the steps, over which hits are counted
  double hit_above_ns = 0;        ///< a step that exceeds the median by this or more counts as hit
  std::vector<double> excess_ns;  ///< excess of each step that was hit, ascending
  std::int64_t alike = 0;         ///< how many of these are within 20 % of the commonest; if at least half: spikes
  double tail_distance = 0;       ///< Kolmogorov distance of the others to the proposed Pareto distribution

  double segment_median_ns = 0;
  double segment_variation = 0;  ///< robust variation of T
  double work_variation = 0;     ///< of V + N s, over T: by how much T would vary without pacing
  double idle_share = 0;         ///< share of the time; concurrent: of the time of the visualization's lane
  double between_share = 0;      ///< share of that idle time that lies between the steps of a segment
  bool spread = false;           ///< paced, and at least half of it does: steps wait for their slots (frame_governor.h)
  std::int64_t late = 0;         ///< segments more than 1 % longer than the grid's
};

/// Fewer segments than this are not enough for a fit.
inline constexpr std::size_t kLeastSegmentsToFit = 32;

/// Why no timing can be fitted to these segments (as read from timing.csv); empty if one can. There must be at least
/// kLeastSegmentsToFit of them, and at least one in ten must have a step.
std::string fit_objection(std::span<const SegmentTiming> segments);
TimingFit fit_timing(std::span<const SegmentTiming> segments);

}  // namespace evenstep
