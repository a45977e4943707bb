#include "evenstep/remap/buffer_oracle.h"

#include <deque>

namespace evenstep {
namespace {

using internal::extend_lower;
using internal::extend_upper;
using internal::Point;
using internal::Slope;

/// The tube, and the taut string through it as the list of its bends.
class Funnel {
 public:
  Funnel(std::span<const StepTimes> steps, Duration latency, Duration sampling_term, Slope slot)
      : steps_(steps), latency_(latency), sampling_term_(sampling_term), slot_(slot) {}

  /// The least and the largest R(n) allowed.
  Point low(std::size_t n) const { return {static_cast<std::int64_t>(n), (steps_[n].end - latency_).ns}; }
  Point high(std::size_t n) const { return {static_cast<std::int64_t>(n), (steps_[n].begin - sampling_term_).ns}; }

  std::vector<Point> bends();
  /// A point of the line of slope tau* that lies in the middle between its bounds.
  Point middle() const { return {bottom_.n, bottom_.ns + (rise_above(bottom_, top_) >> 1)}; }

 private:
  /// How far b lies above the line of slope tau* through a, rounded down.
  std::int64_t rise_above(Point a, Point b) const { return b.ns - a.ns + floor_mul_div(a.n - b.n, slot_.rise, slot_.run); }
  bool above(Point a, Point b) const {  // b strictly above the line through a
    return static_cast<__int128>(b.ns - a.ns) * slot_.run > static_cast<__int128>(b.n - a.n) * slot_.rise;
  }
  bool free_start();
  void narrow(Point low, Point high);
  void free_end();

  std::span<const StepTimes> steps_;
  Duration latency_;
  Duration sampling_term_;
  Slope slot_;
  Point bottom_{};  // for lines of slope tau*: the highest lower bound and the lowest upper bound so far
  Point top_{};
  std::deque<Point> lower_;  // the chain from the apex that is concave over the lower bounds
  std::deque<Point> upper_;  // the chain from the apex that is convex under the upper bounds
  std::vector<Point> bends_;
};

/// Finds the first bend. The first step that no line of slope tau* can reach lies beyond one of the two bounds found so
/// far, and the string bends at that bound. False if such a line fits all steps.
bool Funnel::free_start() {
  bottom_ = low(0);
  top_ = high(0);
  for (std::size_t n = 1; n < steps_.size(); ++n) {
    if (above(top_, low(n))) {
      bends_.push_back(top_);
      return true;
    }
    if (above(high(n), bottom_)) {
      bends_.push_back(bottom_);
      return true;
    }
    if (!above(low(n), bottom_)) bottom_ = low(n);
    if (!above(top_, high(n))) top_ = high(n);
  }
  return false;
}

/// Adds the bounds of one more step. A bound beyond the opposite chain pulls the string around the points of that chain:
/// they become bends, and the apex moves to the last of them. The other chain then consists of the new bound alone, because
/// its former points lie within the old funnel.
void Funnel::narrow(Point low, Point high) {
  extend_upper(lower_, low);
  while (lower_.size() == 2 && upper_.size() >= 2 && Slope(upper_[0], upper_[1]) < Slope(lower_[0], low)) {
    upper_.pop_front();
    bends_.push_back(upper_[0]);
    lower_ = {upper_[0], low};
  }
  extend_lower(upper_, high);
  while (upper_.size() == 2 && lower_.size() >= 2 && Slope(upper_[0], high) < Slope(lower_[0], lower_[1])) {
    lower_.pop_front();
    bends_.push_back(lower_[0]);
    upper_ = {lower_[0], high};
  }
}

/// Continues from the apex with slope tau*, or follows the chain that stands in the way until it no longer does.
void Funnel::free_end() {
  for (; lower_.size() >= 2 && slot_ < Slope(lower_[0], lower_[1]); lower_.pop_front()) bends_.push_back(lower_[1]);
  for (; upper_.size() >= 2 && Slope(upper_[0], upper_[1]) < slot_; upper_.pop_front()) bends_.push_back(upper_[1]);
}

std::vector<Point> Funnel::bends() {
  if (!free_start()) return {};
  lower_ = upper_ = {bends_[0]};
  for (auto n = static_cast<std::size_t>(bends_[0].n) + 1; n < steps_.size(); ++n) narrow(low(n), high(n));
  free_end();
  return bends_;
}

}  // namespace

internal::Bracket RunningLine::bracket() const {
  if (ends_.empty()) return {};
  // g(tau) = max(E - n tau) - min(S - n tau) has the slope (n of the begin that binds) - (n of the end that binds). As tau
  // grows from -infinity, the binding end moves leftwards along the upper hull and the binding begin rightwards along the
  // lower hull; g is least where they meet or pass each other. For a single step they meet at once.
  std::size_t end = ends_.size() - 1;
  std::size_t begin = 0;
  Slope tau;
  while (begins_[begin].n < ends_[end].n) {
    const bool end_moves = begin + 1 == begins_.size() ||
                           (end > 0 && Slope(ends_[end - 1], ends_[end]) <= Slope(begins_[begin], begins_[begin + 1]));
    tau = end_moves ? Slope(ends_[end - 1], ends_[end]) : Slope(begins_[begin], begins_[begin + 1]);
    if (end_moves)
      --end;
    else
      ++begin;
  }
  // ceil((E - S) - (n_E - n_S) tau), exactly.
  const std::int64_t slots_ns = floor_mul_div(ends_[end].n - begins_[begin].n, tau.rise, tau.run);
  return {.latency = Duration{ends_[end].ns - begins_[begin].ns - slots_ns},
          .slot = tau,
          .end = ends_[end].n,
          .begin = begins_[begin].n};
}

BestLine RunningLine::best() const {
  const internal::Bracket line = bracket();
  return {.latency = line.latency,
          .slot_ns = static_cast<double>(line.slot.rise) / static_cast<double>(line.slot.run),
          .latency_culprit = line.end,
          .lead_culprit = line.begin};
}

BestLine best_line(std::span<const StepTimes> steps) {
  RunningLine line;
  for (std::size_t n = 0; n < steps.size(); ++n) line.add(static_cast<std::int64_t>(n), steps[n].begin, steps[n].end);
  return line.best();
}

LeastPath least_path(std::span<const StepTimes> steps) {
  RunningPath path;
  for (std::size_t n = 0; n < steps.size(); ++n) path.add(static_cast<std::int64_t>(n), steps[n].begin, steps[n].end);
  return path.least();
}

void interpolate(std::span<StepTimes> steps) {
  for (std::size_t n = 0; n + 1 < steps.size(); ++n) steps[n].end = steps[n + 1].end;
}

TautString taut_string(std::span<const StepTimes> steps, Duration latency, Duration sampling_term) {
  TautString string;
  RunningLine line;
  for (std::size_t n = 0; n < steps.size(); ++n) line.add(static_cast<std::int64_t>(n), steps[n].begin, steps[n].end);
  const Slope slot = line.bracket().slot;
  Funnel funnel(steps, latency, sampling_term, slot);
  for (std::size_t n = 0; n < steps.size(); ++n) {
    if (funnel.low(n).ns <= funnel.high(n).ns) continue;
    string.infeasible_step = n;
    return string;
  }
  if (steps.empty()) return string;
  const std::vector<Point> bends = funnel.bends();
  for (const Point& bend : bends) string.bends.push_back(static_cast<std::size_t>(bend.n));
  const std::vector<Point> through = bends.empty() ? std::vector<Point>{funnel.middle()} : bends;
  std::size_t next = 0;  // first bend at or after n
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto n = static_cast<std::int64_t>(i);
    while (next < through.size() && through[next].n < n) ++next;
    const bool between = next > 0 && next < through.size();
    const Point from = through[next > 0 ? next - 1 : 0];
    const Slope slope = between ? Slope(from, through[next]) : slot;
    string.reads.push_back(RealTime{from.ns + floor_mul_div(n - from.n, slope.rise, slope.run)});
  }
  return string;
}

}  // namespace evenstep
