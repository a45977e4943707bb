#pragma once
/// How fast simulated time passes against real time. Where it is not the same, whatever moves in the scene moves too fast or
/// too slowly for the hand that touches it.

#include <cstdint>
#include <span>
#include <string>

#include "evenstep/time/time.h"

namespace evenstep {

struct Pace {
  double step_s = 0;  ///< simulated time per step
  std::int64_t steps = 0, segments = 0;
  RealTime first, last;  ///< begins of the first step and of the last one
  Duration longest_segment;

  /// In order of time.
  void add_segment(const Interval& segment, std::span<const Interval> of_it);
  /// From the begin of the first step to that of the last one; 1 if there are no two.
  double simulated_per_real() const;
  /// Whether they differ by 1 % or less, beyond what a segment holds, whose steps may all be at its begin or at its end. Of
  /// fewer than three segments nothing can be said.
  bool keeps_real_time() const;
};

/// "simulated time passes 12.8 times as fast as real time: to a hand all that moves is too fast; with a step size of ...";
/// empty if it keeps real time.
std::string text(const Pace& pace);

struct StrategyRecord;
/// Of a run, with steps of this length; nothing for a strategy whose steps are as long as they took.
Pace pace_of(const StrategyRecord& strategy, double step_s);

}  // namespace evenstep
