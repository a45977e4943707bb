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
/// the tube: towards a slower pace at E_n - L, towards a faster one at S_n - d. O(n) amortized (a funnel).
/// (It does not minimize second differences: its largest velocity jump is no bound for those of maps.)
///
/// Least latency of any path, straight or not, that never steps back: for m <= n,  E_m - L <= R(m) <= R(n) <= S_n - d.
///   L_path = max over n of [max over m <= n of E_m  -  S_n] + d
/// is therefore necessary, and R(n) = max over m <= n of (E_m - L_path) is such a path: it never steps back, and it is in
/// the tube. Steps that do not overlap have E_m <= S_n for m < n, so the longest step decides:  L_path = max(E_n - S_n) + d.
/// No map of constant latency does with less, whatever it knows of the future: the bound that no scheme beats.
///
/// Interpolated forces: step n's line begins at F(n - 1), so its force is due then: E_{n+1} <= F(n). `interpolate` moves
/// the ends by one step; all of the above then holds of what it leaves.
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
  std::int64_t latency_culprit = -1;   ///< position of a step whose end the line touches when emitting
  std::int64_t lead_culprit = -1;      ///< position of a step whose begin it touches when reading
};
/// Steps in order (index = position). One step or none: latency = the step's run time or 0, slot 0.
BestLine best_line(std::span<const StepTimes> steps);

namespace internal {

struct Point {
  std::int64_t n;
  std::int64_t ns;
};

/// A slope in ns per step, as the exact fraction rise / run with run > 0.
struct Slope {
  std::int64_t rise = 0;
  std::int64_t run = 1;
  Slope() = default;
  Slope(Point a, Point b) : rise(b.ns - a.ns), run(b.n - a.n) {}
  friend bool operator<=(Slope a, Slope b) {
    return static_cast<__int128>(a.rise) * b.run <= static_cast<__int128>(b.rise) * a.run;
  }
  friend bool operator<(Slope a, Slope b) { return !(b <= a); }
};

/// One point more on the hull whose slopes fall (upper) or rise (lower) from left to right.
template <class Hull>
void extend_upper(Hull& hull, Point p) {
  while (hull.size() >= 2 && Slope(hull[hull.size() - 2], hull.back()) <= Slope(hull.back(), p)) hull.pop_back();
  hull.push_back(p);
}
template <class Hull>
void extend_lower(Hull& hull, Point p) {
  while (hull.size() >= 2 && Slope(hull.back(), p) <= Slope(hull[hull.size() - 2], hull.back())) hull.pop_back();
  hull.push_back(p);
}

struct Bracket {
  Duration latency;
  Slope slot;
  std::int64_t end = -1, begin = -1;   // steps whose end and begin it touches
};

}  // namespace internal

/// best_line, one step more at a time. It keeps the hulls, which are short, and not the steps.
class RunningLine {
 public:
  /// n counts up.
  void add(std::int64_t n, RealTime begin, RealTime end) {
    internal::extend_upper(ends_, {n, end.ns});
    internal::extend_lower(begins_, {n, begin.ns});
  }
  /// The steps of another line, all of them behind those of this one.
  void append(const RunningLine& later) {
    for (const internal::Point end : later.ends_) internal::extend_upper(ends_, end);
    for (const internal::Point begin : later.begins_) internal::extend_lower(begins_, begin);
  }
  void restart() {
    ends_.clear();
    begins_.clear();
  }
  /// Culprits are named by their n.
  BestLine best() const;
  internal::Bracket bracket() const;

 private:
  std::vector<internal::Point> ends_, begins_;
};

struct LeastPath {
  Duration latency;                    ///< L_path without the sampling term
  std::int64_t latency_culprit = -1;   ///< position of the step whose end decides; -1: no steps
};
/// Steps in order; they may overlap.
LeastPath least_path(std::span<const StepTimes> steps);

/// least_path, one step more at a time.
class RunningPath {
 public:
  /// n counts up from 0 or more.
  void add(std::int64_t n, RealTime begin, RealTime end) {
    if (latest_ < 0 || end > latest_end_) {
      latest_ = n;
      latest_end_ = end;
    }
    const Duration needed = latest_end_ - begin;
    if (least_.latency_culprit < 0 || needed > least_.latency) least_ = {needed, latest_};
  }
  void restart() { *this = {}; }
  const LeastPath& least() const { return least_; }

 private:
  LeastPath least_;
  std::int64_t latest_ = -1;   // of the steps so far, the one that ends last
  RealTime latest_end_;
};

/// End n becomes that of step n + 1; the last stays.
void interpolate(std::span<StepTimes> steps);

struct TautString {
  std::optional<std::size_t> infeasible_step;  ///< first step with E_n - L > S_n - d: no path at all, reads are empty
  std::vector<RealTime> reads;                 ///< R(n), one per step, floored to ns; in the tube, never stepping back
  std::vector<std::size_t> bends;              ///< steps at which it bends, ascending; there R(n) is exact
};
/// Steps in order, begins and ends never decreasing. L >= L*: the best line, in the middle of the tube, no bends.
TautString taut_string(std::span<const StepTimes> steps, Duration latency, Duration sampling_term);

}  // namespace evenstep
