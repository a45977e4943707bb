#pragma once
/// Reads the parts of [timing] that describe how run times vary. Equations: scheduler/step_timing.h.

#include "evenstep/scheduler/step_timing.h"
#include "src/check.h"

namespace evenstep::internal {

inline constexpr std::size_t kMostStepCounts = 1000;
/// `steps` of [timing] or of a change: a number or a list.
std::vector<int> read_step_counts(const Table& table, Errors& errors);

/// Reads jitter and the models into `timing`, whose means and order must be known already. Adds an error for each model that
/// makes no sense with them.
void read_timing_models(const Table& table, ProgrammedTiming& timing, Errors& errors);

/// Adds an error for a paced schedule that can never catch up, because its mean work, including what the models add, is
/// longer than its segment at the beginning or after a change.
void check_pace(const Table& table, const ProgrammedTiming& timing, Errors& errors);

}  // namespace evenstep::internal
