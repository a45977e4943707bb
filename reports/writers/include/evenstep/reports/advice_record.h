#pragma once
/// What `evenstep advise` found: choices of map, governor, latency and renderer for one timing, and what each costs. The
/// record is filled in by evenstep/campaigns/advise.h; the writers here turn it into text, JSON and a figure. Definitions:
/// docs/choose/advise.md.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/reports/pause_parts.h"
#include "evenstep/reports/size_record.h"
#include "evenstep/time/time.h"

namespace evenstep {

/// One choice. The numbers come from the run of its scenario, except `bound` (from the sizing) and the stiffness (from a
/// law).
struct AdviceChoice {
  int number = 0;  ///< from 1 on
  std::string map;
  double bandwidth_Hz = 0;   ///< of the map; 0: it has none
  std::string governor;      ///< in words, as the table says it; empty: the simulator's pace is left as it is
  double allowed_jump = 0;   ///< [remap] jump, if it is not the default; else 0
  double accepted_rate = 0;  ///< share of segments whose forces may be late; 0: none
  bool adaptive = false;     ///< the latency follows what the steps need
  std::string renderer;      ///< "hold", "linear", "local" or "device_spring"
  bool needs_stiffness = false, needs_springs = false;  ///< the solver's stiffness; springs by the device
  std::string scenario;                                 ///< the text that reproduces it
  std::string stops_scenario;  ///< for a map that predicts: the text that reproduces `stop_error_m`; else empty

  /// Why there are no numbers (the run failed); empty if there are.
  std::string failure;
  /// L and c of the map; 0 for `direct`, which has none. L of an adaptive latency is its mean, L of `predict` is 0.
  Duration latency, lead;
  std::optional<Duration> latency_most;  ///< for an adaptive one: the most that it may become
  std::optional<Duration> bound;         ///< least L of any path that jumps as little, no force late; empty: none
  std::optional<SizeUnseen>
      unseen;                  ///< for the least L: how such a size does on what it has not seen; empty: too few segments
  double delay_s = 0;          ///< hand to force, with hold and device; for `direct` and an adaptive latency the mean
  double jump_step = 0;        ///< velocity jump of what the solver reads, in the hand's way per slot
  double force_jump_step = 0;  ///< of the force at the ticks, in the change of force per slot
  double underrun_rate = 0;    ///< share of the judged segments with an underrun
  /// Share of all segments that are late at the worst phase of the device (from the sizing: the run has one phase only); 0
  /// for a map that is given its least latency.
  double late_any_phase = 0;
  /// For a map that predicts: the largest error of the positions given to the solver where the hand stops, and the time that
  /// the hand takes for that distance, 0 if it is no more than a sample is old. A longer time is made up: the map runs on. 0
  /// for all other maps.
  double stop_error_m = 0, runs_on_s = 0;
  /// The stiffness that the loop carries, by its law; for an adaptive latency at the most that it may become.
  double stiffness_N_per_m = 0;
  bool searched = false;     ///< there is no law: the largest with which a hand came to rest in a search
  double tried_N_per_m = 0;  ///< [scene] stiffness of the run
  /// Whether the hand of the run comes to rest with that stiffness; empty: the run is too short to tell.
  std::optional<bool> comes_to_rest;
  double drawings_lost = 0, simulated_lost = 0;  ///< shares, against the timing as it was recorded

  Duration drawings_later;  ///< most by which a drawing begins later than it was recorded, if none is lost

  bool ranked = false;            ///< all its prices are known, and its hand comes to rest as far as can be told
  bool on_front = false;          ///< no other ranked choice that needs no more beats it
  std::vector<int> dominated_by;  ///< numbers of choices on the front
  std::vector<int> ties;          ///< numbers of the choices whose prices are the same
};

struct AdviceRecord {
  std::string input;
  std::string segments_from;  ///< as SizeRecord has it
  std::int64_t steps = 0, segments = 0;
  Duration length, slot, warmup;
  Duration sampling_period;
  Duration pause_bound;  ///< of the timing as it was recorded, for held forces
  PauseParts pause;      ///< the one that sets it
  double damping_N_s_per_m = 0, mass_kg = 0, firmware_rate_Hz = 0, speed_m_per_s = 0;
  std::vector<std::string> notes;  ///< what was left out, and why
  std::vector<AdviceChoice> choices;
};

/// Prices in the order in which they are compared; less is better. They are rounded to three digits, because a smaller
/// difference is no reason to choose. Jumps below 0.001 steps count as 0. docs/choose/advise.md lists them.
std::vector<double> prices_of(const AdviceChoice& choice);
/// Sets ranked, on_front, dominated_by and ties of all choices.
void rank(AdviceRecord& record);

/// The choice to use if the solver says how stiff it is, or if it gives forces only; null if there is none. Only choices on
/// the front count that draw and simulate as recorded, with no force late, and without governor, springs, adaptive latency,
/// a jump other than the default, or running on. Of those that jump by at most 0.15 steps it is the one with the least
/// delay; if none is as smooth, it is the one that jumps least.
const AdviceChoice* choice_to_use(const AdviceRecord& record, bool solver_gives_stiffness);

/// Text for people: the table, and what to choose when. The sentences, but not the table, are wrapped at `columns`.
inline constexpr std::size_t kAdviceColumns = 120;
std::string advice_text(const AdviceRecord& record, std::size_t columns = kAdviceColumns);
/// One JSON object; docs/choose/advise.md lists its keys. Times are in whole ns where they are exact.
std::string advice_json(const AdviceRecord& record);
/// A figure: delay against velocity jump and against stiffness, with the front. Empty if nothing is ranked.
std::string advice_svg(const AdviceRecord& record);
/// The conclusion alone, a line or more for each case.
std::vector<std::string> advice_conclusion(const AdviceRecord& record);
/// "phase_locked 2 Hz, split 2, 1 % late, local"
std::string name_of(const AdviceChoice& choice);
/// The share of segments that may be late: that of the run or that at the worst phase, whichever is larger.
double late_share(const AdviceChoice& choice);

}  // namespace evenstep
