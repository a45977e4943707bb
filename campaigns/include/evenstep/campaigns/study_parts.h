#pragma once
/// A study of any kind in shards (parts.h). Item 0 of a study with a reference is that reference, of which every shard needs
/// its own; the others are its cells. A stiffness limit has an item for each strategy.
///
/// Errors are reproducible, so these members of a line are the same wherever its cell was computed. What was measured is in
/// its member `measured`: costs, and the machine that they are of. A merge keeps each from the shard that measured it.

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
  std::vector<std::string> set;  ///< what has changed the scenario, for its digest
  Registry registry;
  std::string cache_folder;  ///< as in FeltStudyControl
  std::function<void(const std::string& line)> announce;
};
struct StudyPartsOutcome : PartOutcome {
  /// Of the whole study; nothing of a shard, or if it was interrupted.
  std::variant<std::monostate, StudyRecord, FeltStudyRecord, StiffnessLimits> record;
};
/// `scenario` is that of `path` with the options' overrides, and one that can be studied. Costs are measured one by one, so
/// only a stiffness limit heeds PartOptions::threads.
StudyPartsOutcome run_study_parts(const Scenario& scenario, const std::string& path, const StudyPartsOptions& options);

}  // namespace evenstep
