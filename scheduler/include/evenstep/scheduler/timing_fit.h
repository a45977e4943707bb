#pragma once
/// From a recording to a programmed timing: each part of ProgrammedTiming estimated by itself, with what it rests on.
/// The estimates are robust (medians, trimmed means), because a recording holds a cold start and an unfinished last segment;
/// that last one is left out. What a model cannot say is lost: whether that matters is for the caller to compare
/// (campaigns/fit_report.h does, by the latency both need).

#include <span>
#include <string>
#include <vector>

#include "evenstep/scheduler/step_timing.h"

namespace evenstep {

/// A duration that varies: log-normal about `mean`, once everything else that is known of it has been taken off.
struct FittedLength {
  std::int64_t count = 0;
  double median_ns = 0;
  double mean_ns = 0;    ///< of what lies within 5 deviations of the median, in logarithm
  double variation = 0;  ///< coefficient of variation, from the median absolute deviation of the logarithm
  double distance = 0;   ///< Kolmogorov's, to that log-normal
};

/// An estimate and its standard error.
struct FittedNumber {
  double value = 0;
  double error = 0;
};

struct TimingFit {
  ProgrammedTiming timing;  ///< the proposal; seed 1

  std::int64_t segments = 0;  ///< used
  double seconds = 0;
  /// In `timing` where either is 4 errors from 0 and makes 2 %, and both agree within 3 errors.
  FittedNumber visualization_drift_per_s, step_drift_per_s;
  FittedLength visualization;            ///< without drift, regimes and what is merged
  std::int64_t dropped = 0, merged = 0;  ///< segments
  double lag_1 = 0;                      ///< correlation of neighbouring visualizations, before regimes are taken off
  double regime_separation = 0;          ///< distance of the two levels in deviations within one; 0: one level explains it
  double slow_share = 0;                 ///< of the segments, where there are two levels

  int least_steps = 0, most_steps = 0;
  double mean_steps = 0;
  FittedLength step;              ///< neither the first after a visualization nor hit
  FittedNumber first_step;        ///< in `timing` where it is 3 errors and 2 % above 0
  FittedNumber slowdown{1, 0};    ///< concurrent: of steps that begin beside a visualization
  double work_s = 0;              ///< of steps: what hits are counted against
  double hit_above_ns = 0;        ///< an excess over the median from which on a step counts as hit
  std::vector<double> excess_ns;  ///< of the steps hit, ascending
  std::int64_t alike = 0;         ///< of these, those within 20 % of the commonest excess: spikes, if at least half
  double tail_distance = 0;       ///< Kolmogorov's, of the others to the Pareto proposed

  double segment_median_ns = 0;
  double segment_variation = 0;  ///< of T, robust
  double work_variation = 0;     ///< of V + N s over T: what T would vary by without pacing
  double idle_share = 0;         ///< of the time; concurrent: of the visualization's lane
  std::int64_t late = 0;         ///< segments more than 1 % longer than the grid's
};

/// Fewer segments than this say nothing.
inline constexpr std::size_t kLeastSegmentsToFit = 32;

/// `segments` as read from timing.csv; at least kLeastSegmentsToFit, of which one in ten has a visualization and one a step.
/// Empty error: fine; otherwise what is missing.
std::string fit_objection(std::span<const SegmentTiming> segments);
TimingFit fit_timing(std::span<const SegmentTiming> segments);

}  // namespace evenstep
