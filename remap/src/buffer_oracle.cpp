#include "evenstep/remap/buffer_oracle.h"

#include <vector>

namespace evenstep {
namespace {

struct Point {
  std::int64_t n;
  std::int64_t ns;
};

/// A slope in ns per step, as the exact fraction rise / run with run > 0.
struct Slope {
  std::int64_t rise;
  std::int64_t run;
  Slope(Point a, Point b) : rise(b.ns - a.ns), run(b.n - a.n) {}
  friend bool operator<=(Slope a, Slope b) {
    return static_cast<__int128>(a.rise) * b.run <= static_cast<__int128>(b.rise) * a.run;
  }
};

/// One point more on the hull whose slopes fall (upper) or rise (lower) from left to right.
void extend_upper(std::vector<Point>& hull, Point p) {
  while (hull.size() >= 2 && Slope(hull[hull.size() - 2], hull.back()) <= Slope(hull.back(), p)) hull.pop_back();
  hull.push_back(p);
}
void extend_lower(std::vector<Point>& hull, Point p) {
  while (hull.size() >= 2 && Slope(hull.back(), p) <= Slope(hull[hull.size() - 2], hull.back())) hull.pop_back();
  hull.push_back(p);
}

}  // namespace

BestLine best_line(std::span<const StepTimes> steps) {
  if (steps.empty()) return {};
  if (steps.size() == 1) return {steps[0].end - steps[0].begin};
  std::vector<Point> ends;
  std::vector<Point> begins;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    extend_upper(ends, {static_cast<std::int64_t>(i), steps[i].end.ns});
    extend_lower(begins, {static_cast<std::int64_t>(i), steps[i].begin.ns});
  }
  // g(tau) = max(E - n tau) - min(S - n tau) has the slope (n of the begin that binds) - (n of the end that binds). From
  // tau = -infinity upwards the binding end walks the upper hull leftwards and the binding begin the lower hull
  // rightwards; where they meet or pass g is least.
  std::size_t end = ends.size() - 1;
  std::size_t begin = 0;
  for (;;) {
    const bool end_moves = begin + 1 == begins.size() ||
                           (end > 0 && Slope(ends[end - 1], ends[end]) <= Slope(begins[begin], begins[begin + 1]));
    const Slope tau = end_moves ? Slope(ends[end - 1], ends[end]) : Slope(begins[begin], begins[begin + 1]);
    if (end_moves) --end; else ++begin;
    if (begins[begin].n < ends[end].n) continue;
    // ceil((E - S) - (n_E - n_S) tau), exactly.
    const std::int64_t slots_ns = floor_mul_div(ends[end].n - begins[begin].n, tau.rise, tau.run);
    const double slot_ns = static_cast<double>(tau.rise) / static_cast<double>(tau.run);
    return {Duration{ends[end].ns - begins[begin].ns - slots_ns}, slot_ns};
  }
}

}  // namespace evenstep
