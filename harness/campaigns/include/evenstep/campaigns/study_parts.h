#pragma once
/// A study of any kind in shards (parts.h). In a study with a reference, item 0 is the reference, of which every shard needs
/// its own; the other items are the cells. A stiffness limit has an item for each strategy.
///
/// Errors are reproducible, so those members of a line are the same wherever its cell was computed. What was measured
/// (costs, and the machine that they belong to) is in the line's member `measured`. A merge keeps it from the shard that
/// measured it.

#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "evenstep/campaigns/parts.h"
#include "evenstep/format/reader.h"
#include "evenstep/reports/felt_study_record.h"
#include "evenstep/reports/stiffness_limits.h"
#include "evenstep/reports/study_record.h"

namespace evenstep {

struct StudyPartsOptions : PartOptions {
  std::vector<std::string> set;  ///< the --set of the scenario, for its digest
  Registry registry;
  std::string cache_folder;  ///< as in FeltStudyControl
  std::function<void(const std::string& line)> announce;
};
struct StudyPartsOutcome : PartOutcome {
  /// The record of the whole study; empty for a single shard or if it was interrupted.
  std::variant<std::monostate, StudyRecord, FeltStudyRecord, StiffnessLimits> record;
};
/// `scenario` is that of `path` with the options' overrides, and one that can be studied. Costs are measured one by one, so
/// only a stiffness limit heeds PartOptions::threads.
StudyPartsOutcome run_study_parts(const Scenario& scenario, const std::string& path, const StudyPartsOptions& options);

}  // namespace evenstep
