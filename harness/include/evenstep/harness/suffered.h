#pragma once
/// What a run suffered and no expectation asks about. A run can pass and still have lost what its author did not think of;
/// this says so, on the virtual and on the wall clock.
///
/// Counted are: forces that were late, samples that were missing, entries that a ring overwrote before they were read,
/// forces that were dropped, lost reports, failed writes and cuts of the guard, for each device and strategy; and steps that
/// did not begin, particles that are not finite, and simulated time that passes faster or slower than real time in a scene
/// that moves by itself (evenstep/reports/pace.h), for each strategy. Saturated samples are told apart (saturation.h).

#include <string>
#include <vector>

#include "evenstep/harness/run.h"

namespace evenstep {

/// "left.phase_locked: 1800 of 1800 forces late; nothing asserts this": one for those devices and strategies that suffered
/// the same. What an expectation that was judged names (a `*` included) is left out.
std::vector<std::string> suffered(const RunOutcome& outcome);
/// The same as text, each line beginning with "went wrong".
std::string suffered_lines(const RunOutcome& outcome);

}  // namespace evenstep
