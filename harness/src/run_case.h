#pragma once
/// A scenario with a [case]: every cell of its sweep, and its expectations.

#include "evenstep/harness/run.h"

namespace evenstep::internal {

/// The same as run_scenario, for Scenario::case_spec. Wall clock: an error, there is nothing to wait for.
void run_case(const Scenario& scenario, const RunOptions& options, RunOutcome& outcome);

/// opencl computes what cpu does, bit for bit: where both ran, `device_difference` says whether they did.
void compare_devices(CaseRecord& record);

}  // namespace evenstep::internal
