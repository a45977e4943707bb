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
/// begins at or after the end of the step before it, also across segments. Idle time is what lies between. Segments follow
/// each other in order of begin; where the visualization has a lane of its own, a step may end in the next segment.
struct SegmentTiming {
  std::int64_t index = 0;
  RealTime begin;                          ///< B_k: the boundary
  std::optional<Interval> visualization;   ///< none where it is dropped or the scene has none
  std::vector<Interval> steps;             ///< N_k of them; N_k may be 0
  RealTime end;                            ///< end of the last thing in it (visualization, step or idle)
  bool concurrent = false;                 ///< programmed so: overlaps(), even if no step of this segment meets it

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

/// What opens a segment; concurrent: the visualization has a lane of its own and stops no step.
enum class SegmentOrder { visualization_first, steps_first, concurrent };

/// Something that hits a step now and then and adds the same to it every time (a scheduler's tick).
struct Spikes {
  double rate_Hz = 0;
  Duration cost;
};

/// Another program that takes the processor from a step or a visualization now and then, for a time that is Pareto
/// distributed between `least` and `most`: P(cost > x) = ((least/x)^a - (least/most)^a) / (1 - (least/most)^a), a = tail.
struct Preemption {
  double rate_Hz = 0;
  Duration least, most;
  double tail = 1.5;
};

/// The visualization jumps between two lengths, `factor` apart, and stays at each for `mean_length` segments on average.
struct Regimes {
  double factor = 1;
  double mean_length = 8;
};

/// New values from the first segment on that begins at or after `at`. What is not named stays as it was.
struct TimingChange {
  RealTime at;
  std::optional<Duration> visualization;
  std::optional<Duration> step;
  std::vector<int> steps;                  ///< empty: as before
};

/// [timing] of a scenario, without a trace. Nothing else than the fields below decides the schedule.
struct ProgrammedTiming {
  Rate segment{30, 1};                     ///< 1 / T; of a free-running schedule only the mean step of "fill" depends on it
  Duration visualization{11'100'000};      ///< V, mean; 0: there is none
  std::vector<int> steps{15};              ///< N; several values: drawn uniformly per segment from the seed
  std::optional<Duration> step;            ///< s, mean; none = "fill", see make_programmed_timing
  SegmentOrder order = SegmentOrder::visualization_first;
  double visualization_variation = 0;      ///< log-normal coefficient of variation
  double step_variation = 0;
  double first_step = 0;                   ///< the first step after a visualization takes 1 + first_step times as long
  std::optional<Spikes> spikes;
  std::optional<Preemption> preemption;
  std::optional<Regimes> regimes;
  double drift_per_s = 0;                  ///< r
  double dropped_visualization = 0;        ///< probability per segment; with `merged` at most 1
  double merged_visualization = 0;
  std::vector<TimingChange> changes;       ///< `at` strictly increasing
  bool paced = false;
  double slowdown = 1;                     ///< concurrent: of a step that begins while a visualization runs
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
/// Free-running, where anything varies: each duration is rounded to ns (at least 1) and appended to the one before; no
///   idle; a segment begins where the one before ends, so the boundaries wander. mean(s) = (T - V) / mean(N) for "fill",
///   rounded to ns; what the models below add comes on top of T.
///
/// Paced, where anything varies and `paced` is set: segment k begins at max(floor(k * 1e9 / rate), end of the work of
///   segment k - 1); what is left is idle. A late segment skips nothing: the ones after it run without idle until they have
///   caught up. Steps first: the visualization ends at floor((k + 1) * 1e9 / rate) if it can, and follows the steps if not.
///
/// Concurrent: visualizations follow each other, paced or back to back; steps follow each other beside them and are never
///   stopped. Segment k lasts from the begin of visualization k to the next one's and holds the steps that begin in it, so
///   N varies. `steps` only serves "fill": s = (V / slowdown + T - V) / N, where T = V if not paced; that gives N steps per
///   segment on average. (Where it is paced and the phase of the steps to V is even, those that straddle an end of V make it
///   (slowdown - 1)^2 / (2 slowdown) fewer: 0.08 at 1.5.)
///
/// Length of step n, in segment k: d = floor(X_n (1 + r B_k) f + 1/2), and then d + spike_n + preemption_n;
/// of visualization k:             d = floor(Y_k (1 + r B_k) c_k + 1/2), and then d + preemption_k.
///   X_n, Y_k      log-normal (random.h) about s and V; r: drift_per_s, B_k in s (never below 0 for the reader's values)
///   f             1 + first_step for the first step after a visualization; slowdown for one that begins beside one; else 1
///   c_k           0 with probability dropped_visualization, 2 with merged_visualization, else 1
///   regimes       V is 2 V / (1 + factor) or factor times that; the first one by a fair draw, left at the end of a segment
///                 with probability 1 / mean_length. The mean stays V; lag-1 correlation 1 - 2 / mean_length.
///   spike_n       `cost` with probability 1 - exp(-rate d), else 0
///   preemption    with the same probability a cost by the inverse CDF: least (1 - u (1 - (least/most)^a))^(-1/a)
///   changes       V, s and N of segment k are those of the last change with at <= B_k. "fill" keeps the s it began with: a
///                 GPU's step gets no faster because its visualization got slower.
/// Draw n of each stream belongs to the global step number n or to segment k, and each model has streams of its own: adding
/// one shifts no other's draws.
std::unique_ptr<StepTiming> make_programmed_timing(const ProgrammedTiming& timing);

/// The periodic case above: one N, and nothing in it varies.
bool is_periodic(const ProgrammedTiming& timing);

/// The mean step at the start of a run: `step`, or that of "fill".
Duration starting_step(const ProgrammedTiming& timing);

/// Expected lengths at the start of a run, that is without drift and changes. Exact but for these: the probability of a hit
/// is that of a piece of work of mean length, and `concurrent` neglects what straddles an end of V (see above).
struct MeanTiming {
  double segment_ns = 0;                   ///< of work: V and the steps; concurrent: of visualizations. Pacing adds idle
  double visualization_ns = 0;             ///< per segment
  double step_ns = 0;
  double steps = 0;                        ///< per segment, if T is no longer than segment_ns; concurrent: per T
};
MeanTiming mean_timing(const ProgrammedTiming& timing);

/// Plays a recording. `segments` as read from timing.csv (recordings/timing_csv.h), already validated.
std::unique_ptr<StepTiming> make_replayed_timing(std::vector<SegmentTiming> segments);

}  // namespace evenstep
