#pragma once
/// A timing as lengths, and back.

#include <optional>
#include <string>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/campaigns/shrink.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

class TimingShape {
 public:
  /// The segments that a run of the scenario begins. Nominal are the lengths of [timing]; of a recording, the medians.
  explicit TimingShape(const Scenario& scenario);

  const std::vector<Perturbation>& perturbations() const { return perturbations_; }
  std::size_t segments() const { return segments_.size(); }
  /// The nominal timing with these: so many segments of it.
  std::vector<SegmentTiming> build(const std::vector<Perturbation>& perturbations, std::size_t segments) const;

 private:
  struct Lengths {
    std::int64_t visualization = 0, visualization_gap = 0;  // ns; no visualization: 0
    std::size_t steps_before = 0;                           // the visualization
    std::vector<std::int64_t> steps, gaps;
  };
  struct Nominal {
    std::int64_t visualization = 0, visualization_gap = 0, step = 0, gap = 0;
    std::size_t count = 0, steps_before = 0;
  };
  void measure(const std::vector<SegmentTiming>& segments);
  void set_nominal(const Scenario& scenario);
  void compare();
  std::vector<Lengths> lengths(const std::vector<Perturbation>& perturbations) const;
  std::vector<SegmentTiming> in_turn(const std::vector<Lengths>& all) const;
  std::vector<SegmentTiming> side_by_side(const std::vector<Lengths>& all) const;

  std::vector<Lengths> segments_;  // as they were; with a lane for visualizations, all steps are in the first one
  bool lanes_ = false;
  std::optional<Rate> grid_;  // segments wait for it, so gaps are no lengths of their own
  Nominal nominal_;
  std::vector<Perturbation> perturbations_;
};

/// As harness/timing_csv.h reads it.
std::string timing_csv_of(const std::vector<SegmentTiming>& segments);

}  // namespace evenstep::internal
