#pragma once
/// The largest stiffness of the scene at which a hand that feels the force comes to rest, for each strategy of the scenario
/// with the plan (lead, latency, rings) of its own run.
///
/// The search goes up from the first stiffness in steps of 15 % to the first one that is not stable, and then bisects until
/// the two ends are within 1 %. A stiffness is stable if, with every seed, every hand ends its run as Oscillation::stable
/// demands (reports/measures.h) over the judged part of the scenario, and nothing diverges. Only [scene] `stiffness` is
/// varied; regions and couplings keep theirs. The search finds the first limit it meets: it may miss an unstable gap
/// narrower than 15 %, and does not look for stable values above the first unstable one.

#include <string>

#include "evenstep/campaigns/study.h"
#include "evenstep/format/scenario.h"
#include "evenstep/harness/run_folder.h"
#include "evenstep/reports/stiffness_limits.h"

namespace evenstep {

/// The scenario must have a [study] stiffness_limit. Throws RunFailure for any failure except a run that diverged. If it is
/// interrupted, it returns the strategies that were finished.
StiffnessLimits run_stiffness_limits(const Scenario& scenario, const StudyControl& control = {});

/// The files of its folder, study.json first.
std::vector<FolderFile> stiffness_files(const Scenario& scenario, const StiffnessLimits& study,
                                        const std::string& reproduce);

/// Writes study.json, study.csv and resolved.toml, all or nothing. Returns what went wrong; empty if nothing did.
std::string write_stiffness_folder(const std::string& folder, const Scenario& scenario, const StiffnessLimits& study,
                                   const std::string& reproduce);

}  // namespace evenstep
