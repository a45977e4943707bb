#pragma once
/// The cells of a study of the felt force, one by one, so that shards can divide them. A cell is a method and step, with
/// every strategy.

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "evenstep/campaigns/felt_study.h"
#include "reference.h"
#include "runs.h"
#include "src/study/trace.h"

namespace evenstep::internal {

/// A strategy, with its values that do not depend on method and step.
struct FeltStrategy {
  StrategyPlan plan;
  std::vector<double> ideal_age_s, age_s;  ///< per device: with an ideal device, with the scenario's
};

class FeltCells {
 public:
  /// Both must outlive it. Throws RunFailure.
  FeltCells(const Scenario& scenario, const FeltStudyControl& control);

  std::size_t count() const { return cells_.size(); }
  std::size_t strategies() const { return strategies_.size(); }
  bool interrupted() const { return run_control_.is_interrupted(); }
  /// The record without its reference, ticks and points.
  FeltStudyRecord description() const;
  /// Prepares what all cells need: the reference, read or computed, and the ages of the strategies. cell() does so if nobody
  /// has.
  void prepare();
  const FeltReferenceInfo& reference() const { return reference_.info; }  ///< after prepare()
  std::int64_t ticks() const { return ticks_; }                           ///< after prepare()
  /// A point for each strategy; without meaning if it was interrupted. Throws RunFailure.
  std::vector<FeltPoint> cell(std::size_t c);

 private:
  double step_s() const { return period_s(scenario_.scene.step_rate); }
  void announce(const std::string& line) const;
  void take_reference();
  void put_scale();
  std::vector<Duration> leads() const;
  std::string method_of(const StudyRun& run) const;
  std::map<std::int64_t, EvenForces> step_and_time(const Scenario& changed, const StudyRun& run, FeltPoint& point);
  std::string first_bad(const EvenForces& forces) const;
  void compare(const Scenario& changed, const FeltStrategy& judged, const EvenForces& even, FeltPoint& point);

  const Scenario& scenario_;
  const FeltStudyControl& control_;
  RunControl run_control_;
  std::vector<StudyRun> cells_;
  std::vector<FeltStrategy> strategies_;
  FeltReference reference_;
  std::int64_t ticks_ = 0;
  bool prepared_ = false;
};

/// The points of all cells in the order of the record: by strategy first.
void put_points(FeltStudyRecord& record, const std::vector<std::vector<FeltPoint>>& cells);

}  // namespace evenstep::internal
