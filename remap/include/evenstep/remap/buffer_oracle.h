#pragma once
/// The bounds that no remap can beat on a given trace, known in full: what the reports compare the maps with.
///
/// Every map of constant latency L is a path R through the tube  E_n - L <= R(n) <= S_n - d,  d = h - 1 ns the sampling
/// term at any phase (0 for a hand known at all times).
///
/// Best straight line, over all R(n) = a + n tau:
///   L* = min over tau of [max(E_n - n tau) - min(S_n - n tau)] + d
/// by the upper hull of (n, E_n) and the lower hull of (n, S_n): the bracket, which is what best_line returns, is
/// convex and piecewise linear in tau. O(n).
///
/// Below L* no line fits, and the taut string is the best path: among all in the tube it has the least sum of
/// f(R(n+1) - R(n) - tau*), for every convex f at once, tau* the slot of the best line. It bends only where it touches
/// the
/// tube: towards a slower pace at E_n - L, towards a faster one at S_n - d. O(n) amortized (a funnel).
/// (It does not minimize second differences: its largest velocity jump is no bound for those of maps.)
///
/// Exact: slopes are compared as rationals with 128-bit products.

#include <optional>
#include <span>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

struct BestLine {
  Duration latency;          ///< ceil of L* to 1 ns, without the sampling term
  double slot_ns = 0;        ///< tau of the minimum
};
/// Steps in order (index = position). One step or none: latency = the step's run time or 0, slot 0.
BestLine best_line(std::span<const StepTimes> steps);

struct TautString {
  std::optional<std::size_t> infeasible_step;  ///< first step with E_n - L > S_n - d: no path at all, reads are empty
  std::vector<RealTime> reads;                 ///< R(n), one per step, floored to ns; in the tube, never stepping back
  std::vector<std::size_t> bends;              ///< steps at which it bends, ascending; there R(n) is exact
};
/// Steps in order, begins and ends never decreasing. L >= L*: the best line, in the middle of the tube, no bends.
TautString taut_string(std::span<const StepTimes> steps, Duration latency, Duration sampling_term);

}  // namespace evenstep
