#pragma once
/// The largest stiffness of the scene at which a hand that feels the force comes to rest: for each strategy of the scenario,
/// with the plan (lead, latency, rings) of its own run.
///
/// Upward from the first stiffness in steps of 15 % to the first that is not stable, then bisected until the two ends are
/// within 1 %. Stable: with every seed, every hand ends a run as Oscillation::stable says (reports/measures.h), over what the
/// scenario judges; a run in which something diverged is not. What is varied is [scene] `stiffness`; regions and couplings
/// keep theirs. It finds the first limit on its ladder: a stable island above an unstable gap narrower than 15 % is missed.

#include <string>

#include "evenstep/format/scenario.h"
#include "evenstep/campaigns/study.h"
#include "evenstep/reports/stiffness_limits.h"

namespace evenstep {

/// The scenario must have a [study] stiffness_limit. Throws RunFailure for anything but a run that diverged. Interrupted: the
/// strategies that were finished.
StiffnessLimits run_stiffness_limits(const Scenario& scenario, const StudyControl& control = {});

/// study.json, study.csv and resolved.toml; whole or not at all. Empty: written.
std::string write_stiffness_folder(const std::string& folder, const Scenario& scenario, const StiffnessLimits& study);

}  // namespace evenstep
