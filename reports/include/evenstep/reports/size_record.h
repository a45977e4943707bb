#pragma once
/// What `evenstep size` found: how much latency a trace needs, what needs it, and what it costs. The campaign fills the record
/// (evenstep/campaigns/size.h), the writers here turn it into text and JSON. Definitions: docs/sizing.md.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

/// Least latencies of the windows of 250 ms (remap/step_windows.h); nearest rank.
struct SizeWindows {
  Duration p50, p99, most;
  std::int64_t count = 0;
};

/// The step whose end sets the latency, and what in its segment or the two before it came latest.
struct SizeCulprit {
  std::int64_t step = -1;         ///< sets the latency; counted over the whole input from 0; -1: no steps
  std::int64_t segment = -1, index = -1;
  RealTime begin;
  /// The step that ran, or was held up before it began, longer than usual by most; -1: all were as usual.
  std::int64_t late_step = -1;
  Duration pause_excess, run_excess;   ///< of that step over the medians; 0 where it was no longer
  Duration mended_latency;        ///< the latency if both had been the medians
};

/// A least latency, at any phase of the device, with the forces held or interpolated.
struct SizeNeed {
  Duration latency;
  SizeWindows windows;
  SizeCulprit culprit;
  Duration total_delay;           ///< latency, and where forces are held half a slot more: the mean age of a staircase
  double stiffness_limit_N_per_m = 0;   ///< damping / (h / 2 + total_delay)
};

/// The least latency at which no more than some segments underrun.
struct SizeRateNeed {
  Duration latency, lead;
  std::int64_t underruns = 0;     ///< segments with an underrun at this latency and lead: as many as allowed, or fewer
  double rate_at_most = 1;        ///< upper bound of Clopper and Pearson on the true rate, at the confidence asked for
};

/// What a rate of segments with an underrun takes.
struct SizeRate {
  std::int64_t segments = 0;      ///< with a mapped step
  std::int64_t allowed = 0;       ///< floor(rate * segments)
  SizeRateNeed any_phase, this_phase;
  /// At any phase, the least latency at which so few segments underrun that the bound is no more than the rate; none where
  /// not even a latency without underruns would show it.
  std::optional<SizeRateNeed> sure;
};

struct SizeStrategy {
  std::string name;
  SizeNeed any_phase;
  Duration lead;                  ///< c of any_phase
  Duration latency_this_phase, lead_this_phase;
  std::int64_t lead_culprit = -1;
  std::int64_t interaction_capacity = 0, force_capacity = 0;
  std::optional<SizeRate> rate;
};

/// Both for the same emission.
struct SizeBounds {
  SizeNeed best_line, taut_string;
};

/// The repeating cycle as found in the step times alone (remap/step_cycle.h).
struct SizeCycle {
  bool found = false;
  std::string reason;             ///< why not
  std::int64_t segments = 0, steps_per_segment = 0, least_steps = 0, most_steps = 0;
  std::int64_t first_boundary = 0;   ///< the first step behind a long pause
  Duration period, pause, longest_gap;
  double period_variation = 0, confidence = 0, regularity = 0;
};

struct SizeRecord {
  std::string input;              ///< file
  std::int64_t steps = 0;         ///< judged
  std::int64_t left_out = 0;      ///< steps before the first long pause of a list without segments
  std::int64_t segments = 0;
  std::string segments_from;      ///< "programmed", "recording", "cycle" (found) or "step" (each is one)
  Duration length;                ///< first begin to last end
  Duration sampling_period;       ///< h: the longest of the devices'
  bool interpolated = false;      ///< emission of the strategies
  double damping_N_s_per_m = 1;
  std::optional<double> rate;     ///< of segments that may underrun; what follows belongs to it
  double confidence = 0.95;
  std::int64_t clean_segments = 0;   ///< so many without an underrun would show the rate
  SizeBounds held;
  std::optional<SizeBounds> linear;    ///< if interpolated
  std::vector<SizeStrategy> strategies;
  std::optional<SizeCycle> cycle; ///< of a bare list
};

/// For people. ms with six decimals, which is ns.
std::string size_text(const SizeRecord& record);
/// One object; keys in docs/sizing.md. Times in whole ns.
std::string size_json(const SizeRecord& record);

}  // namespace evenstep
