#pragma once
/// How sure a rate of underruns is. The map runs alone over this timing with further seeds: no solver, no device, nothing
/// but the schedule and the map, with the lead and latency of the run that is judged.
///
/// Counted are segments: an underrun rarely comes alone, and what happens within a segment is one event. k of n segments
/// with one or more bound the true rate p from above, one-sided, at a confidence C (Clopper and Pearson, Biometrika 26,
/// 1934): the p at which so few would turn up with probability 1 - C. With k = 0 that is 1 - (1 - C)^(1/n), about 3/n at 95
/// %. Segments are taken as independent draws; lateness that spans several makes the bound a little too sure.

#include <cstdint>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"

namespace evenstep::internal {

enum class UnderrunSide { interaction, force, either };

/// A signal that has a rate of underruns, and what it is the rate of. Only maps have one.
struct RateSignal {
  std::string name;
  StrategyKind kind = StrategyKind::phase_locked;
  UnderrunSide side = UnderrunSide::either;
  std::size_t device = 0;
};
std::vector<RateSignal> rate_signals(const Scenario& scenario);

struct RateCount {
  std::int64_t segments = 0;   ///< with a judged step
  std::int64_t hit = 0;        ///< of them with an underrun
};

/// Of the scenario's seed and those after it: `seeds` of them.
RateCount count_underrun_segments(const Scenario& scenario, const RateSignal& signal, Duration lead, Duration latency,
                                  std::int64_t seeds);
/// Segments with a judged step that one seed has.
std::int64_t judged_segments(const Scenario& scenario, StrategyKind kind);

/// The fewest segments that, all clean, bound the rate of underruns by `rate`. rate in (0, 1), confidence in (0, 1).
std::int64_t clean_segments(double rate, double confidence);

/// Seeds that have so many segments, if all have as many as the scenario's own; 0: no segment is judged.
std::int64_t seeds_with(const Scenario& scenario, StrategyKind kind, std::int64_t segments);
inline constexpr std::int64_t kMostSeeds = 1'000'000;

/// Seeds that an expectation with a confidence is judged over; 0: no segment is judged.
std::int64_t seeds_judged(const Scenario& scenario, const Expectation& expectation, StrategyKind kind);

/// Different seeds are different schedules: not so for a recording, and where nothing varies.
bool seeds_differ(const Scenario& scenario);

}  // namespace evenstep::internal

namespace evenstep {

/// Of every expectation with a confidence, what it takes: one line each, for people.
std::vector<std::string> explain_rates(const Scenario& scenario);

}  // namespace evenstep
