#pragma once
/// The real times that the GPU's work takes: for every time segment (paper, section 3), when its visualization and its steps
/// run. All sources give absolute instants, so a schedule never drifts away from what was programmed.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

/// What a frame governor (frame_governor.h) makes of a segment's drawing. Without a governor, each is drawn whole.
struct DrawingPart {
  int parts = 1;                    ///< over how many pauses the drawing is shared out
  std::optional<Duration> at_most;  ///< this pause may take no longer: what is left is drawn in the next ones
  bool finishes = true;             ///< as far as is programmed, the picture is complete when the visualization ends
  bool left_out = false;            ///< a drawing should have begun here, and none does
  friend bool operator==(const DrawingPart&, const DrawingPart&) = default;
};

/// How the result of a step comes to the device.
struct Transport {
  Duration delay;     ///< from the end of the step until it is there
  bool lost = false;  ///< it never comes
};

/// One visualization and the steps up to the next one. No step begins before `begin`. Steps do not overlap: each begins at
/// or after the end of the step before it, also from one segment to the next. Any time in between is idle. Segments follow
/// each other in order of begin; if the visualization has a lane of its own, a step may end in the next segment.
struct SegmentTiming {
  std::int64_t index = 0;
  RealTime begin;                         ///< B_k: the boundary
  std::optional<Interval> visualization;  ///< empty if it was dropped or there is none
  std::vector<Interval> steps;            ///< N_k of them; N_k may be 0
  RealTime end;                           ///< end of the last thing in it (visualization, step or idle)
  bool concurrent = false;                ///< programmed as concurrent: overlaps() even if no step here meets it
  DrawingPart drawing;                    ///< without a visualization only `left_out` has a meaning
  std::vector<Transport> transports;      ///< one per step; empty: every result is there as soon as its step ends
  /// t(n), one per step: where the loop's own simulation time stands when the step begins. Time that the loop drops is
  /// passed over: t is then by so much more than a step size after the t before. Empty: the loop keeps no such time.
  std::vector<SimTime> simulated;

  /// Whether the visualization runs beside the steps, in a lane of its own, and not before or after them: it has more than
  /// an instant in common with a step, or `concurrent` is set.
  bool overlaps() const;
  /// Of a step that is an element of `steps`.
  Transport transport(const Interval& step) const {
    return transports.empty() ? Transport{} : transports[static_cast<std::size_t>(&step - steps.data())];
  }
  std::optional<SimTime> simulated_at(const Interval& step) const {
    if (simulated.empty()) return std::nullopt;
    return simulated[static_cast<std::size_t>(&step - steps.data())];
  }
};

/// Whether any step has a t(n).
bool has_clock(std::span<const SegmentTiming> segments);

class StepTiming {
 public:
  virtual ~StepTiming() = default;
  /// The next segment, or false at the end of a recording (`segment` is then unchanged). `segment`'s storage is reused.
  virtual bool next(SegmentTiming& segment) = 0;
  /// Called if visualizations really run: how long that of the last segment took, and whether the drawing is finished. A
  /// timing whose decisions depend on these uses them instead of what was programmed.
  virtual void visualized(Duration /*took*/, bool /*finished*/) {}
};

/// What a segment begins with. `concurrent`: the visualization has a lane of its own and does not stop any step.
enum class SegmentOrder { visualization_first, steps_first, concurrent };

/// Something that hits a step now and then and makes it longer by the same amount every time (a scheduler's tick).
struct Spikes {
  double rate_Hz = 0;
  Duration cost;
};

/// Another program that takes the processor away from a step or a visualization now and then, for a time with a bounded
/// Pareto distribution between `least` and `most`:
///   P(cost > x) = ((least/x)^a - (least/most)^a) / (1 - (least/most)^a),   a = tail.
struct Preemption {
  double rate_Hz = 0;
  Duration least, most;
  double tail = 1.5;
};

/// The visualization jumps between two lengths, `factor` apart, and stays at a length for `mean_length` segments on average:
/// at the longer one for 2 `slow_share` `mean_length` segments, at the shorter one for the rest of 2 `mean_length`. Both of
/// these stays must be at least 1 segment.
struct Regimes {
  double factor = 1;
  double mean_length = 8;
  double slow_share = 0.5;  ///< share of the segments with the longer one, in (0, 1)
};
/// How many segments it stays, on average, at the length that it has less often.
double shortest_mean_stay(const Regimes& regimes);

/// How the lengths of a piece of work vary about their mean.
enum class JitterLaw {
  log_normal,  ///< `variation` is the coefficient of variation, 0 to 1
  uniform,     ///< within +-`variation` times the mean, all values equally likely; 0 to 1
};

/// When a paced schedule wakes up after a segment that took longer than T.
enum class WakeUp {
  catch_up,         ///< at its own tick, however late: the next segments run without idle time until they have caught up
  absolute_grid,    ///< at the next tick of the grid: ticks that were missed are left out
  from_last_update  ///< T after the previous wake-up, or at once if that has passed: what was lost stays lost
};

/// A long visualization that recurs: the first one that begins at or after each multiple of `every`; `every` is longer than
/// `visualization`.
struct Hitch {
  Duration every;
  Duration visualization;  ///< V of that segment
};

/// The segments that begin in [from, to): only these have spikes, pre-emption, regimes, hitches, dropped and merged
/// visualizations. All other segments have plain V and s.
struct Disturbed {
  RealTime from, to;
  bool holds(RealTime begin) const { return from <= begin && begin < to; }
};

/// New values that apply from the first segment that begins at or after `at`. Values that are not given stay as they were.
struct TimingChange {
  RealTime at;
  std::optional<Duration> visualization;
  std::optional<Duration> step;
  std::vector<int> steps;  ///< empty: unchanged
};

/// A loop with a fixed time step that keeps up with real time ("Fix your timestep!", Glenn Fiedler, 2004,
/// gafferongames.com/post/fix_your_timestep): each frame runs the steps that have become due since the last one.
struct Accumulator {
  Rate step_rate{60, 1};         ///< 1 / dt, dt the step size
  std::optional<int> max_steps;  ///< per frame; the simulated time of those beyond it is dropped; empty: no limit
  Duration jitter_fix;           ///< at most dt: how far N may be from what is due, so that it is as in frames before
  Duration refresh_jitter;       ///< paced: a frame begins later than its refresh by a time drawn evenly from [0, this]
};

/// The table [timing] of a scenario without a trace. The schedule depends on nothing but the fields below.
struct ProgrammedTiming {
  Rate segment{30, 1};                 ///< 1 / T; in a free-running schedule it sets only the mean step of "fill"
  Duration visualization{11'100'000};  ///< V, mean; 0: there is none
  std::vector<int> steps{15};          ///< N; from several values one is drawn per segment, all equally likely
  std::optional<Duration> step;        ///< s, mean; empty means "fill", see make_programmed_timing
  SegmentOrder order = SegmentOrder::visualization_first;
  double visualization_variation = 0;  ///< see JitterLaw
  double step_variation = 0;
  JitterLaw visualization_law = JitterLaw::log_normal, step_law = JitterLaw::log_normal;
  double first_step = 0;  ///< the first step after a visualization takes 1 + first_step times as long
  std::optional<Spikes> spikes;
  std::optional<Preemption> preemption;
  std::optional<Regimes> regimes;
  std::optional<Hitch> hitch;
  std::optional<Disturbed> disturbed;  ///< empty: all segments
  double drift_per_s = 0;              ///< r
  double dropped_visualization = 0;    ///< probability per segment; with `merged` at most 1
  double merged_visualization = 0;
  std::vector<TimingChange> changes;  ///< `at` strictly increasing
  bool paced = false;
  WakeUp wake = WakeUp::catch_up;          ///< paced; other than catch_up only with the visualization first
  double slowdown = 1;                     ///< concurrent: factor on a step that begins while a visualization runs
  std::optional<Accumulator> accumulator;  ///< if given, N follows from it; `steps` and `wake` are not used
  std::uint64_t seed = 1;
};

/// The schedule of a GPU whose times are programmed, for segments k = 0, 1, ... without end.
///
/// Periodic, if N is one number and nothing varies: B_k = floor(k * 1e9 / rate), T_k = B_{k+1} - B_k, no drift.
///   visualization first   V = [B_k, B_k + V], then the steps from B_k + V
///   steps first           the steps from B_k, V = [B_{k+1} - V, B_{k+1}]
///   step i of "fill"      [floor(i (T_k - V) / N), floor((i + 1) (T_k - V) / N)] after the first step's begin
///   step i of fixed s     [i s, (i + 1) s] after it; the rest of T_k comes after the steps and is idle
///                         (T 32 ms, V 8 ms, 16 steps of 1.5 ms: no rest)
///   V + N s <= T is required (for "fill": V + N ns <= T): the scenario reader refuses other values, here they fail an
///   assertion.
///
/// Free-running, if anything varies: each duration is rounded to ns (at least 1) and appended to the one before. There is
///   no idle time: a segment begins where the one before ends, so the boundaries wander. For "fill" mean(s) is
///   (T - V) / mean(N), rounded to ns; the time that the models below add comes on top of T.
///
/// Paced, if anything varies and `paced` is set: segment k begins at max(floor(k * 1e9 / rate), end of the work of
///   segment k - 1); the rest of the time is idle. After a late segment none is skipped: the following ones run without
///   idle time until they have caught up. That is WakeUp::catch_up; the other two begin a segment after work until e that
///   began at b at the first tick floor(j * 1e9 / rate) >= e, and at max(b + floor(T), e). With steps first, the
///   visualization ends at floor((k + 1) * 1e9 / rate) if it can, and otherwise follows the steps.
///
/// Concurrent: visualizations follow each other, paced or back to back; beside them steps follow each other and never stop.
///   Segment k lasts from the begin of visualization k to the begin of the next one and holds the steps that begin in it,
///   so N varies. `steps` is used for "fill" only: s = (V / slowdown + T - V) / N, where T = V if not paced; that gives N
///   steps per segment on average. (If it is paced and the phase of the steps relative to V is spread evenly, the steps that
///   straddle an end of V reduce N by (slowdown - 1)^2 / (2 slowdown): 0.08 at 1.5.)
///
/// Accumulator: a segment is a frame. It begins at B_k, and its N steps are those that are due then, N = 0 included; steps
/// and
///   visualization take turns in either order.
///     m_k = steps run or dropped before frame k,   N = floor(B_k / dt) - m_k,   t(n) = floor(m dt), m that of step n
///   with multiples of dt rounded down to ns, as all times are.
///   `max_steps`: of more steps that are due the oldest are dropped, and m passes over them (as Godot does, main.cpp,
///   max_physics_steps_per_frame).
///   `jitter_fix` j: in each window of the last 1, 2, ..., 12 frames the number of steps is kept to one of two that follow
///   each other, as long as N lies between floor((B_k - j) / dt) - m_k and floor((B_k + j) / dt) - m_k; where that is not
///   possible, the numbers of the windows are learned anew (after Godot's physics_jitter_fix, main_timer_sync.cpp).
///   B_0 = 0. If it is paced (a display that is waited for), frame k begins at the first tick of `segment` after that of
///   frame k - 1 at which its work has ended, plus what is drawn for `refresh_jitter`; else when that work ends. Some frame
///   must take time: V > 0, or it is paced.
///
/// Length of step n, in segment k: d = floor(X_n (1 + r B_k) f + 1/2), and then d + spike_n + preemption_n;
/// of visualization k:             d = floor(Y_k (1 + r B_k) c_k + 1/2), and then d + preemption_k.
///   X_n, Y_k      log-normal (random.h) with means s and V, or uniform: floor(mean (1 + variation (2 u - 1)) + 1/2); r is
///                 drift_per_s, B_k in s; with the values that the reader accepts 1 + r B_k is never below 0
///   f             1 + first_step for the first step after a visualization; slowdown for one that begins beside one; else 1
///   c_k           0 with probability dropped_visualization, 2 with merged_visualization, else 1
///   regimes       with p = slow_share, V is V / (1 - p + p factor) or factor times that. The first level is the longer one
///                 with probability p; at the end of a segment it changes with probability 1 / (2 p mean_length) if it is
///                 the longer one, else 1 / (2 (1 - p) mean_length). The mean stays V; lag-1 correlation 1 - the sum of
///                 these two.
///   spike_n       `cost` with probability 1 - exp(-rate d), else 0
///   preemption    with a probability of the same form, a cost from the inverse CDF:
///                 least (1 - u (1 - (least/most)^a))^(-1/a)
///   hitch         V of segment k is that of the hitch if a multiple j every, j >= 1, lies in (B_{k-1}, B_k]; if this
///                 visualization is dropped, so is the hitch
///   disturbed     outside of it spike_n and preemption are 0, c_k is 1, and V is that of no regime and no hitch; the
///                 segments within have the same draws as without it
///   changes       V, s and N of segment k are those of the last change with at <= B_k. "fill" keeps the s it began with: a
///                 GPU's step does not get faster because its visualization got slower.
/// Draw n of each stream belongs to the global step number n or to segment k, and each model has streams of its own, so
/// adding one model does not shift the draws of another.
std::unique_ptr<StepTiming> make_programmed_timing(const ProgrammedTiming& timing);

/// Whether this is the periodic case above: one N, and nothing varies.
bool is_periodic(const ProgrammedTiming& timing);

/// The mean step at the start of a run: `step`, or what "fill" makes of it.
Duration starting_step(const ProgrammedTiming& timing);

/// Expected lengths at the start of a run: without drift and changes and, if the run has a `disturbed` time, without the
/// models that apply only within it. Exact, with two exceptions: the probability of a hit is computed for work of mean
/// length, and `concurrent` neglects the steps that straddle an end of V (see above).
struct MeanTiming {
  double segment_ns = 0;        ///< the work, V and the steps (concurrent: V alone); pacing adds idle time
  double visualization_ns = 0;  ///< per segment
  double step_ns = 0;
  double steps = 0;  ///< per segment if T is not longer than segment_ns; concurrent: per T
};
MeanTiming mean_timing(const ProgrammedTiming& timing);

/// How long a run must be to contain all of this recording. A run holds the instants before its end, so if the recording
/// ends with a step the run is 1 ns longer, or that step would be cut off.
Duration replay_duration(std::span<const SegmentTiming> segments);

/// Plays a recording. `segments` are those read from timing.csv (recordings/timing_csv.h), already validated.
std::unique_ptr<StepTiming> make_replayed_timing(std::vector<SegmentTiming> segments);

/// step = "real": the steps of a segment run one after the other as fast as the solver can, without a programmed minimum.
std::unique_ptr<StepTiming> make_real_steps(std::unique_ptr<StepTiming> programmed);

}  // namespace evenstep
