#pragma once
/// What a fitted timing (scheduler/timing_fit.h) is worth: the least latency a straight line needs over it, beside that of
/// the recording. The order of segments decides that latency as much as their distribution does, and a model keeps little of
/// it.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evenstep/scheduler/timing_fit.h"

namespace evenstep {

/// best_line (remap/buffer_oracle.h) of the steps that begin in each window of 250 ms, and of all steps. Without the
/// sampling term. A window that begins within 250 ms of the last step is left out, unless there is no other.
struct LatencyNeed {
  Duration window_p50, window_p99;  ///< nearest rank
  Duration whole;
};
LatencyNeed latency_need(std::span<const SegmentTiming> segments);

struct FitComparison {
  LatencyNeed recording;
  std::vector<LatencyNeed> model;     ///< per seed, over as many segments as the recording's
  std::vector<LatencyNeed> shuffled;  ///< per seed: the recording's own segments in another order
  /// Medians over the seeds.
  LatencyNeed model_median, shuffled_median;
};
inline constexpr int kFitSeeds = 9;
FitComparison compare(const TimingFit& fit, std::span<const SegmentTiming> segments, int seeds = kFitSeeds);

/// More than this factor apart, either way, is not the same timing.
inline constexpr double kFitTolerance = 1.5;
/// The needs that differ by more: "250 ms p50", "250 ms p99", "whole recording"; empty: the model will do.
std::vector<std::string> differences(const LatencyNeed& a, const LatencyNeed& b);

/// The proposal as a [timing] table that the reader accepts, comments saying what each line rests on, and the verdict.
/// `file` as the trace to replay instead.
std::string fit_toml(const TimingFit& fit, const FitComparison& comparison, const std::string& file);
std::string fit_json(const TimingFit& fit, const FitComparison& comparison, const std::string& file);

}  // namespace evenstep
