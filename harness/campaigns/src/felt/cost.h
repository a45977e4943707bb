#pragma once
/// The methods and steps of a felt-force study, and what they will cost.

#include <string>
#include <vector>

#include "reference.h"
#include "src/study/trace.h"

namespace evenstep::internal {

/// Every solver, method, number of iterations and step of [study]. Without `step_sizes` there are three steps of each
/// method: the one that substeps = "auto" takes, its half and its quarter. A foreign scene has a cell for each step, by
/// default its own, its half and its quarter. Other scenes have one cell.
std::vector<StudyRun> felt_cells(const Scenario& scenario);
/// The most substeps among the explicit cells.
int finest_substeps(const std::vector<StudyRun>& cells);

struct FeltWork {
  std::size_t strategies = 0;
  std::size_t leads = 0;    ///< different ones among their plans
  std::string stored_file;  ///< the reference that is there already; empty: it will be computed
};
/// What each cell, the reference and all together will take, as lines for people. A few steps of each are timed for it.
std::vector<std::string> cost_lines(const Scenario& scenario, const std::vector<StudyRun>& cells, const ReferencePlan& plan,
                                    const FeltWork& work);

}  // namespace evenstep::internal
