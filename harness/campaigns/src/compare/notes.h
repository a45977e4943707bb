#pragma once
/// What a comparison of two runs says besides their figures.

#include <string>
#include <utility>
#include <vector>

#include "evenstep/campaigns/summary.h"

namespace evenstep::internal {

/// What an expectation of a run is called: its signal as written (which of the signals that a `*` matches is the worst may
/// differ from run to run), and a name that no other expectation on this signal has: "velocity_jump <= 1e-06 step".
struct ExpectationName {
  std::string signal, name;
};
using ExpectationNames = std::vector<ExpectationName>;
/// The names for two runs. The same expectation has the same name in both; one whose limit was changed has its name in B.
std::pair<ExpectationNames, ExpectationNames> expectation_names(const RunSummary& a, const RunSummary& b);

const char* verdict_word(ExpectationResult::Verdict verdict);

/// Why the two are not the same thing measured twice, one reason a line: another scenario, seed, clock, solver, limit, ...
std::vector<std::string> notes_on(const RunSummary& a, const RunSummary& b);

}  // namespace evenstep::internal
