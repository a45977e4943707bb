#pragma once
/// What is known of a run in virtual time before it: the expectations that must fail.

#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/harness/sizing.h"
#include "evenstep/reports/verdict.h"

namespace evenstep {

/// The expectations that cannot hold, by the sizing pass alone: on underruns and late forces, and on latencies, lead and
/// rings, of the strategies that remap. Of any other expectation nothing is said. Nothing is foreseen for a run that
/// [expect_stop] ends early, for a [case], or for expectations on the wall clock.
std::vector<ExpectationResult> foresee_failures(const Scenario& scenario, const std::vector<StrategyPlan>& plans);

}  // namespace evenstep
