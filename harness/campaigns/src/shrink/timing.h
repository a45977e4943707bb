#pragma once
/// Converts a timing to a list of lengths, and back.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/shrink.h"
#include "evenstep/format/scenario.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

class TimingShape {
 public:
  /// Takes the segments that begin in a run of the scenario. The nominal lengths are those of [timing], or the medians of a
  /// recording.
  explicit TimingShape(const Scenario& scenario);

  const std::vector<Perturbation>& perturbations() const { return perturbations_; }
  std::size_t segments() const { return segments_.size(); }
  /// The nominal timing with these perturbations, `segments` segments long.
  std::vector<SegmentTiming> build(const std::vector<Perturbation>& perturbations, std::size_t segments) const;

 private:
  struct Lengths {
    std::int64_t visualization = 0, visualization_gap = 0;  // ns; 0 without a visualization
    std::size_t steps_before = 0;                           // number of steps before the visualization
    std::vector<std::int64_t> steps, gaps, dropped;         // dropped: whole steps of simulated time before each step
  };
  struct Nominal {
    std::int64_t visualization = 0, visualization_gap = 0, step = 0, gap = 0;
    std::size_t count = 0, steps_before = 0;
  };
  void measure(const std::vector<SegmentTiming>& segments);
  void measure_clock(const std::vector<SegmentTiming>& segments, Rate step_rate);
  void set_nominal(const Scenario& scenario);
  void compare();
  std::vector<Lengths> lengths(const std::vector<Perturbation>& perturbations) const;
  std::vector<SegmentTiming> in_turn(const std::vector<Lengths>& all) const;
  std::vector<SegmentTiming> side_by_side(const std::vector<Lengths>& all) const;
  void put_clock(const std::vector<Lengths>& all, std::vector<SegmentTiming>& segments) const;

  std::vector<Lengths> segments_;  // the original ones; with a lane for visualizations, all steps are in the first
  bool lanes_ = false;
  std::optional<Rate> clock_;  // step k of the loop's own time is at sim_time(clock_, k); empty: its t(n) are not such times
  std::int64_t first_step_ = 0;  // k of the first step
  std::optional<Rate> grid_;     // if segments wait for a grid, their gaps follow from it and are no lengths of their own
  Nominal nominal_;
  std::vector<Perturbation> perturbations_;
};

}  // namespace evenstep::internal
