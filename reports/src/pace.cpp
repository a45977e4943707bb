#include "evenstep/reports/pace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evenstep/reports/run_record.h"

namespace evenstep {

namespace {

double simulated_s(const Pace& pace) { return static_cast<double>(pace.steps - 1) * pace.step_s; }

}  // namespace

void Pace::add_segment(const Interval& segment, std::span<const Interval> of_it) {
  ++segments;
  longest_segment = std::max(longest_segment, segment.end - segment.begin);
  if (of_it.empty()) return;
  if (steps == 0) first = of_it.front().begin;
  last = of_it.back().begin;
  steps += std::ssize(of_it);
}

double Pace::simulated_per_real() const { return last > first ? simulated_s(*this) / seconds(last - first) : 1; }

bool Pace::keeps_real_time() const {
  if (last <= first || segments < 3) return true;
  const double real_s = seconds(last - first);
  return std::abs(simulated_s(*this) - real_s) <= 0.01 * real_s + seconds(longest_segment) + step_s;
}

std::string text(const Pace& pace) {
  if (pace.keeps_real_time()) return "";
  const double times = pace.simulated_per_real();
  const bool fast = times > 1;
  std::string out = fmt::format(
      "simulated time passes {:.3g} times as fast as real time: to a hand all that moves is too {}; "
      "with a step size of {:.4g} ms it would keep real time",
      times, fast ? "fast" : "slow", 1e3 * pace.step_s / times);
  if (fast && pace.segments > 0)
    out += fmt::format(", or with segments that wait for their turn, governor = {{ pace = \"{:.4g} ms\" }}",
                       1e3 * static_cast<double>(pace.steps) * pace.step_s / static_cast<double>(pace.segments));
  return out;
}

Pace pace_of(const StrategyRecord& strategy, double step_s) {
  Pace pace{.step_s = step_s};
  if (strategy.variable_step || strategy.steps.empty()) return pace;
  for (const SegmentRow& row : strategy.segments) pace.add_segment({row.begin, row.end}, {});
  pace.steps = static_cast<std::int64_t>(strategy.steps.size());
  pace.first = strategy.steps.front().begin;
  pace.last = strategy.steps.back().begin;
  return pace;
}

}  // namespace evenstep
