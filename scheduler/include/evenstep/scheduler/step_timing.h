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

  /// The visualization runs beside the steps (a lane of its own), not before or after them: it and a step have more than
  /// an instant in common.
  bool overlaps() const;
};

class StepTiming {
 public:
  virtual ~StepTiming() = default;
  /// The next segment, or false at the end of a recording (`segment` is then unchanged). `segment`'s storage is reused.
  virtual bool next(SegmentTiming& segment) = 0;
};

/// [timing] of a scenario, without a trace. Nothing else than the fields below decides the schedule.
struct ProgrammedTiming {
  Rate segment{30, 1};                     ///< 1 / T; of a free-running schedule only the mean step of "fill" depends on it
  Duration visualization{11'100'000};      ///< V, mean; 0: there is none
  std::vector<int> steps{15};              ///< N; several values: drawn uniformly per segment from the seed
  std::optional<Duration> step;            ///< s, mean; none = "fill": the N steps share T - V evenly
  bool steps_first = false;                ///< order = "steps-first"
  double visualization_variation = 0;      ///< log-normal coefficient of variation
  double step_variation = 0;
  std::uint64_t seed = 1;
};

/// The schedule of a GPU whose cost is programmed. Segment k = 0, 1, ... without end.
///
/// Periodic, where N is one number and nothing varies: B_k = floor(k * 1e9 / rate), T_k = B_{k+1} - B_k, no drift.
///   visualization first   V = [B_k, B_k + V], then the steps from B_k + V
///   steps first           the steps from B_k, V = [B_{k+1} - V, B_{k+1}]
///   step i of "fill"      [floor(i (T_k - V) / N), floor((i + 1) (T_k - V) / N)] after the first step's begin
///   step i of fixed s     [i s, (i + 1) s] after it; what is left of T_k comes after the steps and is idle
///                         (T 32 ms, V 8 ms, 16 steps of 1.5 ms: nothing is left)
///   V + N s <= T is required (and N ns for "fill"): the scenario reader refuses other values, here they are assertions.
///
/// Free-running, where a duration varies or N has several values: each duration is rounded to ns and appended to the one
///   before; no idle; a segment begins where the one before ends, so the boundaries wander. mean(s) = (T - V) / mean(N) for
///   "fill", rounded to ns. Draw n of "timing.step" belongs to the global step number n, draw k of "timing.visualization"
///   and of "timing.step_count" to segment k.
std::unique_ptr<StepTiming> make_programmed_timing(const ProgrammedTiming& timing);

/// Plays a recording. `segments` as read from timing.csv (harness/timing_csv.h), already validated.
std::unique_ptr<StepTiming> make_replayed_timing(std::vector<SegmentTiming> segments);

}  // namespace evenstep
