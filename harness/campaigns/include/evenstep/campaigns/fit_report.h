#pragma once
/// How good a fitted timing (scheduler/timing_fit.h) is: compares the least latencies that a straight line and the default
/// map need over it with those that they need over the recording. These depend on the order of the segments as much as on
/// their distribution, and a model keeps little of the order.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "evenstep/reports/pause_parts.h"
#include "evenstep/scheduler/timing_fit.h"

namespace evenstep {

/// The latency of best_line (remap/buffer_oracle.h), without the sampling term, for the steps that begin in each window of
/// 250 ms and for all steps. A window that begins within 250 ms of the last step is left out, unless it is the only one.
struct LatencyNeed {
  Duration window_p50, window_p99;  ///< nearest rank
  Duration whole;
  /// Least latency of `phase_locked` with its default bandwidth: held forces, a device of 1 kHz at any phase.
  Duration phase_locked;
};
LatencyNeed latency_need(std::span<const SegmentTiming> segments);

/// What the scenario reader objects to in the [timing] table of this fit: its first error, or nothing. Some recordings are
/// beyond what a table can express (a segment of 20 s, a visualization 200 times as long at the slow level).
std::string table_objection(const TimingFit& fit);

struct FitComparison {
  std::string objection;  ///< table_objection; if there is one, no model was played
  LatencyNeed recording;
  PauseParts pause;                   ///< what its longest pause consists of
  std::vector<LatencyNeed> model;     ///< per seed, over as many segments as the recording has
  std::vector<LatencyNeed> shuffled;  ///< per seed: the recording's own segments in another order
  /// Medians over the seeds.
  LatencyNeed model_median, shuffled_median;
};
inline constexpr int kFitSeeds = 9;
FitComparison compare(const TimingFit& fit, std::span<const SegmentTiming> segments, int seeds = kFitSeeds);

/// Two timings whose needs differ by more than this factor, either way, are not the same. No map can know the straight line
/// in advance, so its need may differ by more than that of the map that a run uses.
inline constexpr double kFitTolerance = 1.5, kMapTolerance = 1.1;
/// The needs that differ by more than that: "250 ms p50", "250 ms p99", "whole recording", "phase_locked"; empty: the model
/// is good enough.
std::vector<std::string> differences(const LatencyNeed& a, const LatencyNeed& b);

/// The proposal as a [timing] table that the scenario reader accepts, with comments that give the evidence for each line,
/// and the verdict. `file` is named as the trace to replay instead. If there is an objection, the table replays `file`, and
/// the fit is in comments.
std::string fit_toml(const TimingFit& fit, const FitComparison& comparison, const std::string& file);
std::string fitted_table(const TimingFit& fit);  ///< the lines of the fit alone, without [timing]
std::string fit_json(const TimingFit& fit, const FitComparison& comparison, const std::string& file);

}  // namespace evenstep
