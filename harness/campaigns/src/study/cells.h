#pragma once
/// The cells of a study of a tissue's state, one by one, so that shards can divide them.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "evenstep/campaigns/study.h"
#include "trace.h"

namespace evenstep::internal {

class StudyCells {
 public:
  /// Both must outlive it. Throws RunFailure.
  StudyCells(const Scenario& scenario, const StudyControl& control);

  std::size_t count() const { return runs_.size(); }
  /// The record without its reference and cells.
  StudyRecord description() const;
  /// Solved when it is first asked for. Throws RunFailure and StudyInterrupted.
  const StudyReferenceRun& reference();
  /// Without its order. Throws RunFailure, and StudyInterrupted before its cost is known.
  StudyCell cell(std::size_t i);
  const std::string& opencl_device() const { return opencl_device_; }  ///< of a cell so far; empty: none used one

 private:
  double step_s() const { return period_s(scenario_.scene.step_rate); }
  void judge(const StudyRun& run, StudyCell& cell);
  void time(const StudyRun& run, StudyCell& cell) const;

  const Scenario& scenario_;
  const StudyControl& control_;
  std::vector<StudyRun> runs_;
  StudyPlan plan_;
  std::optional<StudyReferenceRun> reference_;
  std::string opencl_device_;
};

/// The orders of all cells, each against the one before it.
void put_orders(StudyRecord& record);

}  // namespace evenstep::internal
