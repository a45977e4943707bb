#pragma once
/// How certain a rate of underruns is. The map runs alone over the timing with further seeds, without solver or device, and
/// with the lead and latency of the run that is judged.
///
/// Segments are counted instead of underruns: an underrun rarely comes alone, and everything within a segment counts as one
/// event. If k of n segments have one or more underruns, the true rate p has an upper bound at the one-sided confidence C
/// (Clopper and Pearson, Biometrika 26, 1934): the p at which k or fewer would occur with probability 1 - C. With k = 0 that
/// is 1 - (1 - C)^(1/n), about 3/n at 95 %. Where late segments come together D of them count as one, and a lead or latency
/// that was computed from this timing was chosen by segments that judge it: both as for `size --rate` (trust.h). Seeds are
/// independent of each other, so D is that of one seed's segments.

#include <cstdint>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"

namespace evenstep::internal {

enum class UnderrunSide { interaction, force, either };

/// A signal that has a rate of underruns, and what the rate is of. Only strategies with a map have such signals.
struct RateSignal {
  std::string name;
  StrategyKind kind = StrategyKind::phase_locked;
  UnderrunSide side = UnderrunSide::either;
  std::size_t device = 0;
};
std::vector<RateSignal> rate_signals(const Scenario& scenario);

struct RateCount {
  std::int64_t segments = 0;  ///< segments with a judged step
  std::int64_t hit = 0;       ///< those of them with an underrun
};

/// Counts over `seeds` seeds: the scenario's own and those after it.
RateCount count_underrun_segments(const Scenario& scenario, const RateSignal& signal, Duration lead, Duration latency,
                                  std::int64_t seeds);
/// How many segments with a judged step one seed has.
std::int64_t judged_segments(const Scenario& scenario, StrategyKind kind);

/// What the segments of a timing say about a rate.
struct RateBasis {
  double alike = 1;     ///< D
  bool chosen = false;  ///< lead or latency were computed from segments that judge them
  std::string refused;  ///< why nobody can be sure of anything: a recording that is not one process; else empty
};
RateBasis rate_basis(const Scenario& scenario, StrategyKind kind);
/// The upper bound on the rate at this confidence.
double underrun_rate_at_most(const RateCount& count, const RateBasis& basis, double confidence);
/// The least number of segments that, if none has an underrun, bounds the rate of underruns by `rate` with this confidence.
/// Both are in (0, 1).
std::int64_t clean_segments(double rate, double confidence, const RateBasis& basis);

/// How many seeds it takes to have that many segments together, if each has as many as the scenario's own; 0: no segment is
/// judged.
std::int64_t seeds_with(const Scenario& scenario, StrategyKind kind, std::int64_t segments);
inline constexpr std::int64_t kMostSeeds = 1'000'000;

/// Over how many seeds an expectation with a confidence is judged; 0: no segment is judged.
std::int64_t seeds_judged(const Scenario& scenario, const Expectation& expectation, StrategyKind kind,
                          const RateBasis& basis);

/// Whether different seeds give different schedules: not for a recording, and not if nothing varies.
bool seeds_differ(const Scenario& scenario);

}  // namespace evenstep::internal

namespace evenstep {

/// For every expectation with a confidence, a line for people that says what it takes to judge it.
std::vector<std::string> explain_rates(const Scenario& scenario);

}  // namespace evenstep
