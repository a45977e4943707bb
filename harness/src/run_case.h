#pragma once
/// Runs a scenario with a [case]: every cell of its sweep, and its expectations.

#include "evenstep/harness/run.h"

namespace evenstep::internal {

/// run_scenario for a Scenario::case_spec. A wall clock is an error, because there is nothing to wait for.
void run_case(const Scenario& scenario, const RunOptions& options, RunOutcome& outcome);

/// opencl must compute the same bits as cpu. Where both ran, the metric `device_difference` says whether they did.
void compare_devices(CaseRecord& record);

}  // namespace evenstep::internal
