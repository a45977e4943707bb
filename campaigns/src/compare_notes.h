#pragma once
/// What a comparison of two runs says besides their figures.

#include <string>
#include <utility>
#include <vector>

#include "evenstep/campaigns/summary.h"

namespace evenstep::internal {

/// A name for each expectation of a run, different from all others on the same signal: "velocity_jump <= 1e-06 step".
using ExpectationNames = std::vector<std::string>;
/// The names for two runs. The same expectation has the same name in both; one whose limit was changed has its name in B.
std::pair<ExpectationNames, ExpectationNames> expectation_names(const RunSummary& a, const RunSummary& b);

const char* verdict_word(ExpectationResult::Verdict verdict);

/// Why the two are not the same thing measured twice, one reason a line: another scenario, seed, clock, solver, limit, ...
std::vector<std::string> notes_on(const RunSummary& a, const RunSummary& b);

}  // namespace evenstep::internal
