#pragma once
/// How good a fitted timing (scheduler/timing_fit.h) is: compares the least latency that a straight line needs over it with
/// the one it needs over the recording. This latency depends on the order of the segments as much as on their distribution,
/// and a model keeps little of the order.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evenstep/scheduler/timing_fit.h"

namespace evenstep {

/// The latency of best_line (remap/buffer_oracle.h), without the sampling term, for the steps that begin in each window of
/// 250 ms and for all steps. A window that begins within 250 ms of the last step is left out, unless it is the only one.
struct LatencyNeed {
  Duration window_p50, window_p99;  ///< nearest rank
  Duration whole;
};
LatencyNeed latency_need(std::span<const SegmentTiming> segments);

struct FitComparison {
  LatencyNeed recording;
  std::vector<LatencyNeed> model;     ///< per seed, over as many segments as the recording has
  std::vector<LatencyNeed> shuffled;  ///< per seed: the recording's own segments in another order
  /// Medians over the seeds.
  LatencyNeed model_median, shuffled_median;
};
inline constexpr int kFitSeeds = 9;
FitComparison compare(const TimingFit& fit, std::span<const SegmentTiming> segments, int seeds = kFitSeeds);

/// Two timings whose needs differ by more than this factor, either way, are not the same.
inline constexpr double kFitTolerance = 1.5;
/// The needs that differ by more: "250 ms p50", "250 ms p99", "whole recording"; empty: the model is good enough.
std::vector<std::string> differences(const LatencyNeed& a, const LatencyNeed& b);

/// The proposal as a [timing] table that the scenario reader accepts, with comments that give the evidence for each line,
/// and the verdict. `file` is named as the trace to replay instead.
std::string fit_toml(const TimingFit& fit, const FitComparison& comparison, const std::string& file);
std::string fit_json(const TimingFit& fit, const FitComparison& comparison, const std::string& file);

}  // namespace evenstep
