#pragma once
/// `evenstep size --within`: one lead c and one latency L with which nothing underruns in any schedule within given bounds,
/// at any phase of the device. H is the sampling term, h - 1 ns. For every map
///   c = sup (slot(n) - S(n)) + H,   L = c + sup (E(n) - slot(n)),   with linear emission c + sup (E(n + 1) - slot(n)),
/// over all schedules and all steps n that the map judges: a program keeps its c and L, whatever comes.
///
/// Segments of one drawing V and N steps s_0, s_1, ..., back to back; each V, s and N anywhere within its bounds, whatever
/// the others are. Lower-case v, s, n are the least, V, S, N the largest. Step i of a segment that begins at B begins at
/// B + V + s_0 + ... + s_(i-1).
///   `linear`   slot = begin: c = H, sup E - slot = S; interpolated, across a boundary, 2 S + V.
///   `paper`    slot = B + i r, where r = T^ / N^ is a mean of T_k / N_k of earlier segments, weighted by their steps, so it
///              lies between v / N + s and V / n + S; one segment that was the first, or many, set it to either end, and V
///              and s of the current segment are free of it. So slot - begin is the largest for i = N - 1, the largest r
///              and the least V and s; E - slot is V + (i + 1) S - i r at the least r, for i = 0 or i = N - 1 (it is linear
///              in i); interpolated, from the last step of a segment of n or N steps, T + V + S - (N - 1) r. Slots that
///              step back are emitted later (SlotMap::emission), which only makes E - slot smaller. It takes average N^.
/// Both are exact: a schedule reaches them (paper: to 1 ns, and what its average has not yet forgotten).
///   `phase_locked`   searched, not derived: random changes of schedules whose V, N and s are all at a bound (each segment's
///              steps change from one bound to the other once at most), for the largest slot - begin and, apart from that,
///              the largest E - slot. The seed and the number of tries are fixed. Found, not proved.
///
/// `clocked` needs a loop that keeps real time: that of `accumulator` (scheduler/step_timing.h), neither paced nor with a
/// limit or a fix of jitter, drawing first. Frame k begins at B_k, where the one before ends, and runs the steps n with
/// t_(n+1) <= B_k that have not run, t_n = floor(n dt); slot(n) = S(0) + t_n. It needs v > 0 and S < dt (each dt rounded to
/// the unfavourable side where it is no whole number of ns):
///   - a frame has at most ceil(T / dt) steps, T the length of the frame before: so no frame is longer than the least
///     T* = V + ceil(T* / dt) S;
///   - the last step of a frame has S(n) >= t_(n+1) + v + (m - 1) s, so S(n) - t_n >= a = dt + v + (m - 1) s, with m the
///     least number of steps, max(1, floor(v / dt)); earlier steps have more;
///   - the first step n of a frame was not due at the begin B of the frame before it: t_(n+1) = B + d with d >= 1 ns. In a
///     time of T* before B as many multiples of dt lie as m(d) = floor((T* + d - 1 ns) / dt), so
///     E(n) - t_n <= b = dt - d + (V + m(d) S) + V + S, the largest for d = 1 ns or the d at which m(d) first grows;
///   - step 0: max(dt, v) + v <= S(0) <= 2 V, and dt - 1 ns more if v < dt.
/// So c = max S(0) - a + H and L = c + b - min S(0) (interpolated: + dt). These are bounds: they are reached where V varies
/// enough for frames to begin at any phase of the clock.
///
/// Rings (LatencyBudget, remap/latency_budget.h), with early = sup (slot - S) and late = L - c:
///   samples: those in (slot - c, S], so in a time of sup (S - slot) + c. For `linear` and `paper` that is exact, with
///     sup (S - slot) = sup (E - slot) - S; for the others, and where E is that of the next step, s in place of S.
///   forces: those of steps m <= n with slot(m) + late >= E(n). As slot(m) <= S(m) + early, they have S(m) >= E(n) - late -
///     early: k of them take k s and have floor((k - 1) / N) drawings between them, so k is the largest with
///     k s + floor((k - 1) / N) v <= early + late. For `linear` one schedule has so many. Slots of `clocked` lie dt apart,
///     between E(n) - late and S(n) + early: at most floor((early + late - s) / dt) + 1.

#include <cstdint>
#include <span>

#include "evenstep/campaigns/size.h"
#include "evenstep/harness/sizing.h"

namespace evenstep::internal {

/// The suprema of a map, without the sampling term.
struct WithinNeeds {
  Duration early;   ///< slot - begin
  Duration late;    ///< end - slot; with linear emission of the next step's end
  Duration behind;  ///< begin - slot
};
WithinNeeds linear_within(const WithinBounds& bounds, Emission emission);
WithinNeeds paper_within(const WithinBounds& bounds, Emission emission);
/// step.most < the step size, visualization.least > 0.
WithinNeeds clocked_within(const WithinBounds& bounds, Rate step_rate, Emission emission);
/// The largest found.
WithinNeeds searched_within(const WithinBounds& bounds, StrategyKind map, Emission emission, std::int64_t& tried);
/// The most forces that wait at once, of a map that needs so much.
std::int64_t waiting_within(const WithinBounds& bounds, const WithinNeeds& needs);
std::int64_t waiting_clocked(const WithinBounds& bounds, Rate step_rate, const WithinNeeds& needs);

}  // namespace evenstep::internal
