#pragma once
/// `evenstep size`: the least latency, lead and rings with which nothing underruns for a given timing. Only the maps are run
/// (docs/choose/sizing.md).

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "evenstep/campaigns/parts.h"
#include "evenstep/campaigns/size_fits.h"
#include "evenstep/campaigns/what_if.h"
#include "evenstep/format/reader.h"
#include "evenstep/format/scenario.h"
#include "evenstep/recordings/recording.h"
#include "evenstep/reports/size_record.h"
#include "evenstep/text/diagnostic.h"

namespace evenstep {

/// --worst-order: what if its hitches came together? Other orders of the recording's segments are searched for the one that
/// needs the most latency (harness/campaigns/src/schedules/worst_order.h).
struct WorstOrderAsked {
  Duration span{1'000'000'000};    ///< no window so long has more hitches than the worst one of the recording
  std::optional<std::string> map;  ///< only this one; default: all, and the order of the one to use is kept
};
/// "1 s, map paper"; the map may be left out. The error says what is wrong.
Result<WorstOrderAsked> parse_worst_order(std::string_view text);

struct SizeOptions {
  /// The rate of the device, which a recording does not contain; the device has a tick where the first step begins.
  Rate sampling{1000, 1};
  Emission emission = Emission::hold;  ///< a recording does not contain this either
  std::optional<double> rate;          ///< share of segments that may underrun, in (0, 1); the latency for it is found, too
  double confidence = 0.95;            ///< confidence of the bound on the rate, in (0, 1)
  std::optional<Duration> per;    ///< a span of time: the latency with which one segment in it is late, or `rate` of them
  double damping_N_s_per_m = 1;   ///< of hand and device, for the stiffness that the closed loop allows
  std::optional<Rate> step_size;  ///< of a recording, steps per second: whether its steps follow a clock of that
  std::optional<SizeFits> fits;   ///< judged: whether that is enough
  bool other_maps = false;        ///< also the maps that are there for comparison only
  std::vector<WhatIf> what_ifs;   ///< each gives a row
  bool adaptive = false;          ///< in these rows also a latency that adapts
  std::optional<WorstOrderAsked> worst_order;
};

struct SizeResult {
  SizeRecord record;
  std::vector<SegmentTiming> segments;  ///< those that were sized
  std::vector<Diagnostic> errors;       ///< empty: the record is complete
  std::vector<SegmentTiming> worst;     ///< the same in the worst order found, if somebody asked
  std::string damage;                   ///< of a profiler's file (read_recording); mostly empty
};

/// For the timing of the scenario, with its devices and map parameters. The latencies and policies that it asks for are
/// ignored.
SizeResult size_scenario(const Scenario& scenario, const SizeOptions& options);

/// For a strategy that remaps, over the timing of its scenario. A timing in which nothing varies is the same for ever. Empty
/// for real steps, whose timing nobody knows, and for a gate, which changes the timing instead of missing anything.
std::optional<TrustedLatency> trusted_latency(const Scenario& scenario, StrategyKind kind);

/// `--within`: bounds of all schedules that are to be safe with one lead and latency
/// (harness/campaigns/src/schedules/within.h).
struct WithinBounds {
  static constexpr std::int64_t kMostSteps = 1000;        ///< in a segment
  static constexpr Duration kLongest{1'000'000'000'000};  ///< of a drawing or a step
  SizeRange visualization, step;                          ///< a drawing may take no time, a step takes at least 1 ns
  std::optional<SizeCounts> steps;                        ///< empty: a frame runs those that are due
};
/// "visualization 9 ms .. 14 ms, step 1.2 ms .. 1.9 ms, steps 10 .. 20". The error says what is wrong.
Result<WithinBounds> parse_within(std::string_view text);
/// Of the options it takes the sampling, the emission and, where there are no `steps`, the step size.
Result<SizeWithin> size_within(const WithinBounds& bounds, const SizeOptions& options);

/// `--seeds`: the scenario with many seeds, which are the items of a campaign in shards (parts.h). A line has what each
/// segment of a seed needs of each map, so one campaign answers every rate and confidence.
struct SizeSeedsOptions : PartOptions {
  std::vector<std::string> set;
  Registry registry;
  std::uint64_t first_seed = 0;
  std::int64_t seeds = 1;  ///< first_seed and those after it
  double rate = 0, confidence = 0.95;
  bool other_maps = false;
};
struct SizeSeedsOutcome : PartOutcome {
  SizeRecord record;  ///< of all seeds: input, segments, rate, confidence, and the name and rate of each strategy
};
/// Sizes the seeds of a shard. If the shard is the whole campaign, or the whole is already complete, the segments of all
/// seeds are taken as one sample, and its latencies are found. It is an error if all seeds have the same timing, as they do
/// for a recording.
SizeSeedsOutcome size_seeds(const std::string& path, const SizeSeedsOptions& options);
/// "0..1000": the first seed, and the one after the last.
Result<std::pair<std::uint64_t, std::int64_t>> parse_seeds(const std::string& text);

/// For a recording: timing.csv (recordings/timing_csv.h), a list of steps with the header begin_ns,end_ns, or a profiler's
/// file with roles (recordings/recording.h). The segments are those of the file. If it has no visualizations and only one
/// segment, the segments are those of the cycle found in it; if there is no cycle either, every step is a segment, and then
/// only the loop of `phase_locked` makes sense, not `paper`.
SizeResult size_recording(const std::string& path, const SizeOptions& options, const RecordingOptions& recording = {});
/// The same for segments in memory, which must contain a step.
SizeRecord size_segments(std::vector<SegmentTiming> segments, const std::string& name, const SizeOptions& options);

}  // namespace evenstep
