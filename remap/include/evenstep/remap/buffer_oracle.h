#pragma once
/// Lower bounds that no remap can beat on a given trace, computed with the whole trace known in advance. The reports
/// compare the maps with them.
///
/// Every map of constant latency L is a path R through the tube  E_n - L <= R(n) <= S_n - d,  where step n begins at S_n
/// and ends at E_n, and d is the sampling term: h - 1 ns for a device of period h at any phase, 0 for a hand whose
/// position is known at all times.
///
/// Best straight line, over all R(n) = a + n tau:
///   L* = min over tau of [max(E_n - n tau) - min(S_n - n tau)] + d
/// The expression in brackets, whose minimum best_line returns, is convex and piecewise linear in tau; it is computed from
/// the upper hull of (n, E_n) and the lower hull of (n, S_n). O(n).
///
/// Below L* no straight line fits, and the taut string is the best path: among all paths in the tube it has the least sum
/// of f(R(n+1) - R(n) - tau*) for every convex f at once, where tau* is the slot of the best line. It bends only where it
/// touches the tube: towards a slower pace at E_n - L, towards a faster one at S_n - d. O(n) amortized (funnel algorithm).
/// (It does not minimize second differences, so its largest velocity jump is no bound for the jumps of maps.)
///
/// Least latency of any path, straight or not, that never steps back: for m <= n,  E_m - L <= R(m) <= R(n) <= S_n - d.
///   L_path = max over n of [max over m <= n of E_m  -  S_n] + d
/// is therefore necessary, and it is enough: R(n) = max over m <= n of (E_m - L_path) is such a path. It never steps back
/// and stays in the tube. Steps that do not overlap have E_m <= S_n for m < n, so the longest step decides:
///   L_path = max(E_n - S_n) + d.
/// No map of constant latency can do with less, however much it knows of the future.
///
/// Interpolated forces: the line to force n begins at F(n - 1), so force n is due then: E_{n+1} <= F(n). `interpolate`
/// moves the ends by one step; everything above then holds for the steps that it returns.
///
/// Exact: slopes are compared as rationals with 128-bit products.

#include <optional>
#include <span>
#include <vector>

#include "evenstep/time/time.h"

namespace evenstep {

struct BestLine {
  Duration latency;                   ///< L* rounded up to 1 ns, without the sampling term
  double slot_ns = 0;                 ///< the tau at which the minimum lies
  std::int64_t latency_culprit = -1;  ///< position of a step whose end limits the line: its force comes just in time
  std::int64_t lead_culprit = -1;     ///< position of a step whose begin limits the line: its sample comes just in time
};
/// Steps in order (n is the position). For one step the latency is its run time, for none 0; the slot is then 0.
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

/// Adds a point to the right end of a hull whose slopes fall (upper) or rise (lower) from left to right.
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
  std::int64_t end = -1, begin = -1;  // the steps whose end and whose begin the line touches
};

}  // namespace internal

/// best_line with the steps given one at a time. It keeps only the hulls, which are short, not the steps.
class RunningLine {
 public:
  /// n must increase from call to call.
  void add(std::int64_t n, RealTime begin, RealTime end) {
    internal::extend_upper(ends_, {n, end.ns});
    internal::extend_lower(begins_, {n, begin.ns});
  }
  /// Adds the steps of another line, all of which come after the steps of this one.
  void append(const RunningLine& later) {
    for (const internal::Point end : later.ends_) internal::extend_upper(ends_, end);
    for (const internal::Point begin : later.begins_) internal::extend_lower(begins_, begin);
  }
  void restart() {
    ends_.clear();
    begins_.clear();
  }
  /// The culprits are given as the n passed to add().
  BestLine best() const;
  internal::Bracket bracket() const;

 private:
  std::vector<internal::Point> ends_, begins_;
};

struct LeastPath {
  Duration latency;                   ///< L_path without the sampling term
  std::int64_t latency_culprit = -1;  ///< position of the step whose end determines it; -1: no steps
};
/// Steps in order; they may overlap.
LeastPath least_path(std::span<const StepTimes> steps);

/// least_path with the steps given one at a time.
class RunningPath {
 public:
  /// n is 0 or more and must increase from call to call.
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
  std::int64_t latest_ = -1;  // of the steps so far, the one that ends last
  RealTime latest_end_;
};

/// Gives each step the end of the step after it; the last one keeps its own.
void interpolate(std::span<StepTimes> steps);

struct TautString {
  std::optional<std::size_t> infeasible_step;  ///< first step with E_n - L > S_n - d: no path exists, `reads` is empty
  std::vector<RealTime> reads;                 ///< R(n), one per step, floored to ns; in the tube, never stepping back
  std::vector<std::size_t> bends;              ///< steps at which the string bends, ascending; R(n) is exact there
};
/// Steps in order, with begins and ends that never decrease. For L >= L* the result is the best line in the middle of the
/// tube, without bends.
TautString taut_string(std::span<const StepTimes> steps, Duration latency, Duration sampling_term);

}  // namespace evenstep
