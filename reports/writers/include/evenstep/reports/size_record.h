#pragma once
/// What `evenstep size` found: how much latency a trace needs, which step needs it, and what it costs. The record is filled
/// in by evenstep/campaigns/size.h; the writers here turn it into text and JSON. Definitions: docs/choose/sizing.md.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/pace.h"
#include "evenstep/reports/pause_parts.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// Percentiles (nearest rank) of the least latencies of the windows of 250 ms (remap/step_windows.h).
struct SizeWindows {
  Duration p50, p99, most;
  std::int64_t count = 0;
};

/// The step whose end sets the latency, and the step in its segment or the two before it that caused the most delay.
struct SizeCulprit {
  std::int64_t step = -1;  ///< the step that sets the latency, counted from 0 over the whole input; -1: no steps
  std::int64_t segment = -1, index = -1;
  RealTime begin;
  /// The step that exceeded the usual pause before it and the usual run time by most; -1: none exceeded them.
  std::int64_t late_step = -1;
  Duration pause_excess, run_excess;  ///< by how much that step exceeded the medians; 0 if it did not
  Duration mended_latency;            ///< the latency if its pause and run time had been the medians
};

/// A least latency, at any phase of the device, with the forces held or interpolated.
struct SizeNeed {
  Duration latency;
  SizeWindows windows;
  SizeCulprit culprit;
  Duration total_delay;                ///< the latency; half a slot more if forces are held, the mean age of a held force
  double stiffness_limit_N_per_m = 0;  ///< damping / (h / 2 + total_delay)
};

/// Sized on the first part of the segments, played on the part after it (harness/campaigns/src/size/unseen.h).
inline constexpr std::int64_t kLeastUnseen = 60;  ///< segments; fewer are not played so
struct SizeUnseen {
  std::int64_t sized = 0, played = 0;  ///< segments
  RealTime from;                       ///< where the played ones begin
  Duration latency, lead;              ///< of the sized ones
  std::int64_t late = 0;               ///< of the played ones, those with an underrun
  Duration late_by, missing_by;        ///< how late a force and a sample were at worst; 0: never
};

/// How much the segments of a recording say about the next ones (harness/include/evenstep/harness/trust.h).
struct SizeTrust {
  std::int64_t segments = 0;
  double alike = 1;  ///< D: so many segments count as one, because late ones come together
  std::int64_t effective() const { return static_cast<std::int64_t>(static_cast<double>(segments) / alike); }
  std::int64_t block = 1;  ///< segments in a block of the test for change
  bool tested = false;     ///< false: too few blocks
  struct Change {
    std::int64_t segment = 0;  ///< the first one after it, counted from 0 over those that were sized
    RealTime from;
  };
  std::optional<Change> change;  ///< the segments before and after are not of one process
  bool one_process() const { return tested && !change; }
};
/// Why a recording is not one process, as far as it can tell.
std::string not_one_process(const SizeTrust& trust);

/// The least latency at which no more than some segments underrun.
struct SizeRateNeed {
  Duration latency, lead;
  std::int64_t underruns = 0;  ///< segments with an underrun at this latency and lead: as many as allowed, or fewer
  /// Upper bound on the true rate at the confidence asked for (trust.h); empty if it is not one process.
  std::optional<double> rate_at_most;
};

/// The latency that is needed if a given rate of segments may have an underrun.
struct SizeRate {
  std::int64_t segments = 0;  ///< with a mapped step
  std::int64_t allowed = 0;   ///< floor(rate * segments)
  SizeRateNeed any_phase, this_phase;
  /// At any phase, the least latency at which so few segments underrun that the upper bound is not above the rate; empty if
  /// it is not one process, or too short.
  std::optional<SizeRateNeed> sure;
  std::int64_t segments_needed = 0;  ///< for `sure`, of one process and all without an underrun
};

/// The latency with which a span of time, perhaps longer than the recording, has at most so many late segments on average
/// (harness/campaigns/src/size/per.h).
struct SizePer {
  double rate = 0;               ///< the share of the segments that this is
  Duration latency, lead;        ///< upper bound at the confidence asked for
  Duration likely_latency;       ///< most likely; the same as `latency` where the recording is long enough to have seen it
  bool beyond = false;           ///< from the tail fitted to the largest needs
  std::int64_t exceedances = 0;  ///< of that tail
  double shape = 0, shape_at_most = 0;  ///< of that tail
  std::string refused;                  ///< why there is no such latency
  Duration to_record;                   ///< how much more would do; 0: nobody can tell
};

/// Of a map in a scenario: the latency to be trusted for an hour, at 95 %. Beside the least latency, which is exact for this
/// timing and says nothing of the next.
struct TrustedLatency {
  static constexpr Duration kSpan{3'600'000'000'000};
  static constexpr double kConfidence = 0.95;
  SizeTrust trust;
  SizePer per;
};
/// "58.123456 ms with a lead of 3.200000 ms", or "cannot be known: " and why, and how much more would do.
std::string text(const TrustedLatency& latency);

/// The least latency of any path (remap/jump_bound.h), or of a map, whose velocity jump is at most `jump`.
struct SizePath {
  double jump = 0;  ///< in mean slots
  Duration latency;
};

struct SizeStrategy {
  std::string name;
  bool for_comparison = false;  ///< never the one to use
  SizeNeed any_phase;
  /// The largest velocity jump of its read times, in mean slots, after the first second, or after the first half of what is
  /// shorter than two seconds.
  double velocity_jump = 0;
  bool jump_seen = true;                 ///< false: there were too few steps, so the jump is 0 and says nothing
  std::optional<SizePath> path;          ///< any path at that jump; empty where there are too many steps
  std::optional<Duration> pauses_bound;  ///< likewise: a map that knows the past only, where pauses come close to each other
  Duration lead;                         ///< c that belongs to any_phase
  Duration latency_this_phase, lead_this_phase;
  std::int64_t lead_culprit = -1;
  std::int64_t interaction_capacity = 0, force_capacity = 0;
  std::vector<SizeUnseen> unseen;  ///< at five places, in order; empty if there are too few segments
  /// All five together: `late` and `played` are sums, `late_by` and `missing_by` the largest; the rest is of the last.
  SizeUnseen all_unseen() const;
  SizeTrust trust;
  std::optional<SizeRate> rate;
  std::optional<SizePer> per;
};

/// Work that took clearly longer than usual, by about the same time: a kind of hitch (docs/choose/sizing.md).
struct SizeHitches {
  /// `waiting`: idle time that the recording says; `gap`: nothing says what it is.
  enum class What { visualization, step, waiting, gap };
  What what = What::gap;
  std::int64_t count = 0;
  Duration shortest, longest;                            ///< lengths of these pieces
  Duration usual;                                        ///< the median of all such pieces
  RealTime first;                                        ///< when the first one begins
  Duration least_between, median_between, most_between;  ///< from begin to begin; 0 if there is only one
  struct Mended {
    Duration latency;              ///< if all of this kind had been as usual
    Duration with_all_above;       ///< the same for this and all kinds above it in the list
    double stiffness_N_per_m = 0;  ///< the stiffness limit at with_all_above
  };
  std::vector<Mended> mended;  ///< in the order of SizeRecord::strategies
  /// Whether they come at equal intervals, to a tenth or a segment.
  bool regular(Duration segment) const;
};

/// All bounds are for the same emission.
struct SizeBounds {
  SizeNeed best_line, taut_string;
  Duration pause;               ///< the pause bound (remap/jump_bound.h)
  std::vector<SizePath> paths;  ///< at rising jumps; empty where there are too many steps
};

/// The repeating cycle as found in the step times alone (remap/step_cycle.h).
struct SizeCycle {
  bool found = false;
  std::string reason;  ///< why not
  std::int64_t segments = 0, steps_per_segment = 0, least_steps = 0, most_steps = 0;
  std::int64_t first_boundary = 0;  ///< the first step after a long pause
  Duration period, pause, longest_gap;
  double period_variation = 0, confidence = 0, regularity = 0;
};

/// A timing with other pauses (evenstep/campaigns/what_if.h): what it needs, and what it costs. The first is the timing as
/// it is.
struct SizeWhatIf {
  struct Adaptive {
    Duration mean;          ///< of a latency that adapts, starting at the least fixed one and never above it
    std::int64_t late = 0;  ///< forces
  };
  struct Map {
    std::string name;
    Duration latency;  ///< the least, at any phase of the device
    double velocity_jump = 0;
    bool jump_seen = true;
    std::optional<Duration> rate_latency;  ///< if the rate of the record may underrun
    std::optional<Adaptive> adaptive;
  };
  std::string text;
  bool causal = false;  ///< a simulator that does not know the future can do it
  std::string refused;  ///< why it has no meaning here; then the rest says nothing
  std::vector<Map> maps;
  Duration pause_bound;
  std::optional<Duration> pace;  ///< the pace that a percentile came to
  std::int64_t drawings = 0, left_out = 0, over_budget = 0;
  double drawings_per_s = 0;
  Duration longest_pause, longest_without;
  double simulated_against_real = 1, segments_lost = 0;
};

/// The same segments in the worst order found (harness/campaigns/src/schedules/worst_order.h).
struct SizeWorstOrder {
  struct Map {
    std::string name;
    Duration latency, lead;              ///< in the order of the recording, at any phase of the device
    Duration worst_latency, worst_lead;  ///< in the worst order found; never less
    std::int64_t tried = 0;              ///< orders
  };
  std::string refused;                     ///< why there is no other order; then the rest says nothing
  Duration span;                           ///< of the windows in which hitches are counted
  std::int64_t hitches = 0, together = 0;  ///< segments; of them in the worst window of the recording, and of any order
  std::string map;                         ///< the one whose order is written
  std::string file;                        ///< where; empty: nowhere
  std::vector<Map> maps;
};

/// Whether what a program has is enough (evenstep size --fits).
struct SizeFit {
  std::string refused;  ///< why the question has no meaning here; then the rest says nothing
  std::string map;
  std::string unknown;  ///< why nobody can say what a span of time needs; then it does not fit, and the rest says nothing
  std::optional<Duration> latency, lead;        ///< what the program has
  std::optional<std::int64_t> samples, forces;  ///< entries of its rings
  Duration needed_latency;                      ///< with the program's lead, if that is enough; else with the least
  Duration needed_lead;
  std::int64_t needed_samples = 0, needed_forces = 0;  ///< with the latency and lead above
  bool fits() const {
    return refused.empty() && unknown.empty() && latency.value_or(needed_latency) >= needed_latency &&
           lead.value_or(needed_lead) >= needed_lead && samples.value_or(needed_samples) >= needed_samples &&
           forces.value_or(needed_forces) >= needed_forces;
  }
};

/// Whether the steps follow a clock of their own, for a given step size (evenstep size --step-size), or for the t(n) that a
/// recording has.
struct SizeClock {
  Duration step;                        ///< step size
  bool follows = false;                 ///< false: the map `clocked` makes no sense and is left out
  double range_steps = 0;               ///< how far frames are from the clock, most minus least, in steps
  std::int64_t dropped = 0, drops = 0;  ///< whole steps that seem to have been dropped, and in how many places
  Pace pace;                            ///< of all steps, with this step size
};

struct SizeRecord {
  std::string input;          ///< file
  std::string trace;          ///< file with these segments; empty: none, or a scenario has it
  std::string trace_roles;    ///< its [timing] roles, in TOML; empty: none are needed
  std::int64_t steps = 0;     ///< steps judged
  std::int64_t left_out = 0;  ///< in a list without segments: the steps before the first long pause
  std::int64_t segments = 0;
  std::int64_t visualizations = 0;  ///< segments that have one
  bool forces_travel = false;       ///< to the device, which takes time; the bounds leave that out
  std::string segments_from;        ///< "programmed", "recording", "cycle" (found) or "step" (each step is a segment)
  Duration length;                  ///< first begin to last end
  Duration segment;                 ///< median, from begin to begin
  Duration sampling_period;         ///< h, the longest of all devices
  bool interpolated = false;        ///< emission of the strategies
  double damping_N_s_per_m = 1;
  std::optional<double> rate;  ///< share of segments that may underrun; the next two are for it
  double confidence = 0.95;
  std::optional<Duration> per;      ///< a span of time; the confidence is for it, too
  std::int64_t clean_segments = 0;  ///< how many segments, independent and without an underrun, would show the rate
  PauseParts pause;                 ///< the one that sets the pause bound
  SizeBounds held;
  std::optional<SizeBounds> linear;  ///< if interpolated
  std::vector<SizeStrategy> strategies;
  std::vector<SizePath> other_jumps;  ///< of phase_locked with half and twice its [remap] jump; empty without this map
  std::vector<SizeHitches> hitches;   ///< in order of the longest excess
  std::vector<SizeWhatIf> what_ifs;   ///< empty if nobody asked
  std::optional<SizeWorstOrder> worst_order;  ///< if somebody asked
  std::optional<SizeFit> fit;                 ///< if somebody asked
  std::optional<SizeCycle> cycle;             ///< for a list of steps without segments
  std::optional<SizeClock> clock;             ///< if the recording has one, or a step size was given
};

struct SizeRange {
  Duration least, most;
};
struct SizeCounts {
  std::int64_t least = 0, most = 0;
};
/// One lead and latency for every schedule within bounds (harness/campaigns/src/schedules/within.h).
struct SizeWithin {
  SizeRange visualization, step;
  std::optional<SizeCounts> steps;    ///< in a segment; empty: a frame runs those that are due
  std::optional<Duration> step_size;  ///< then what a step simulates
  Duration sampling_period;           ///< h
  bool interpolated = false;
  /// `exact`: enough for all, and one schedule needs it; `bound`: enough for all; `found`: the worst that a search found.
  enum class How { exact, bound, found };
  struct Map {
    std::string name;
    How how = How::exact;
    Duration lead, latency;
    std::size_t interaction_capacity = 0, force_capacity = 0;  ///< enough for all; rarely more than one of them needs
    std::int64_t tried = 0;                                    ///< schedules of the search
  };
  std::vector<Map> maps;
};
const char* name_of(SizeWithin::How how);
std::string size_within_text(const SizeWithin& within);
std::string size_within_json(const SizeWithin& within);

const char* name_of(SizeHitches::What what);
/// A sentence, of all parts played together.
std::string text(const SizeUnseen& all);
/// Of the maps whose velocity jump is at most 0.15 slots the one that needs the least latency; if none is as smooth, the map
/// that jumps least. Null if no map has a slot.
const SizeStrategy* strategy_to_use(const SizeRecord& record);

/// What a program lacks, and which hitch to mend, in a few sentences; empty if it fits.
std::string lacking(const SizeRecord& record);

/// Text for people. Times are in ms with six decimals, that is to the ns.
std::string size_text(const SizeRecord& record);
/// All that a record of many seeds has: the latencies for its rate, of all segments together.
std::string size_rates_text(const SizeRecord& record);
std::string size_rates_json(const SizeRecord& record);
/// A figure: latency against velocity jump, the curve of the bounds and a point per map. Empty without a curve.
std::string size_svg(const SizeRecord& record);
/// One JSON object; docs/choose/sizing.md lists its keys. Times are in whole ns.
std::string size_json(const SizeRecord& record);

}  // namespace evenstep
