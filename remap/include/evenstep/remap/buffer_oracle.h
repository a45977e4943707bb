#pragma once
/// The bound no straight-line remap can beat on a given trace: over all R(n) = a + n tau, F(n) = R(n) + L,
///   L* = min over tau of [max(E_n - n tau) - min(S_n - n tau)] + h - 1 ns        (any phase of the sampling)
/// by the upper hull of (n, E_n) and the lower hull of (n, S_n): the bracket, which is what best_line returns, is convex and
/// piecewise linear in tau. O(n).
/// Exact: slopes are compared as rationals with 128-bit products.

#include <span>

#include "evenstep/time/time.h"

namespace evenstep {

struct BestLine {
  Duration latency;          ///< ceil of L* to 1 ns, without the sampling term
  double slot_ns = 0;        ///< tau of the minimum
};
/// Steps in order (index = position). One step or none: latency = the step's run time or 0, slot 0.
BestLine best_line(std::span<const StepTimes> steps);

}  // namespace evenstep
