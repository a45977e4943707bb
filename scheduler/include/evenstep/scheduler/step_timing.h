#pragma once
/// What the GPU costs: for every time segment (paper, section 3) when its visualization and its steps run in real time.
/// Sources produce absolute instants, so that a schedule never drifts from what was programmed.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

struct Interval {
  RealTime begin;
  RealTime end;
};

/// One visualization and the steps up to the next one. begin <= every step's begin; steps are disjoint and in order, each
/// begins at or after the end of the step before it, also across segments. Idle time is what lies between.
struct SegmentTiming {
  std::int64_t index = 0;
  RealTime begin;                          ///< B_k: the boundary
  std::optional<Interval> visualization;   ///< none where it is dropped or the scene has none
  std::vector<Interval> steps;             ///< N_k of them; N_k may be 0
  RealTime end;                            ///< end of the last thing in it (visualization, step or idle)

  /// The visualization runs beside the steps (a lane of its own), not before or after them.
  bool overlaps() const;
};

class StepTiming {
 public:
  virtual ~StepTiming() = default;
  /// The next segment, or false at the end of a recording. `segment`'s storage is reused.
  virtual bool next(SegmentTiming& segment) = 0;
};

/// [timing] of a scenario, without a trace.
struct ProgrammedTiming {
  Rate segment{30, 1};                     ///< 1 / T, for step = fill; ignored where a step duration is given and timing is free-running
  Duration visualization{11'100'000};      ///< V, mean
  std::vector<int> steps{15};              ///< N; several values: drawn uniformly per segment from the seed
  std::optional<Duration> step;            ///< s, mean; none = "fill": the N steps share T - V evenly
  bool steps_first = false;                ///< order = "steps-first"
  double visualization_variation = 0;      ///< log-normal coefficient of variation
  double step_variation = 0;
  std::uint64_t seed = 1;
};

/// Periodic where nothing varies and step = fill: B_k = floor(k * 1e9 / rate), step i ends at
/// B_k + V + floor(i * (B_{k+1} - B_k - V) / N) (visualization first). Otherwise free-running: durations are rounded to
/// ns and appended; with a fixed s and nothing random B_{k+1} = B_k + V + N s, unless [timing] names a segment longer
/// than that: then the rest is idle (ties.toml: T 32 ms = 8 + 16 * 1.5). Several N: free-running with the mean s.
std::unique_ptr<StepTiming> make_programmed_timing(const ProgrammedTiming& timing);

/// Plays a recording. `segments` as read from timing.csv (harness/timing_csv.h), already validated.
std::unique_ptr<StepTiming> make_replayed_timing(std::vector<SegmentTiming> segments);

}  // namespace evenstep
