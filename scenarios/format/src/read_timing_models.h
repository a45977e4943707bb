#pragma once
/// The parts of [timing] that say how run times vary. Equations: scheduler/step_timing.h.

#include "check.h"
#include "evenstep/scheduler/step_timing.h"

namespace evenstep::internal {

inline constexpr std::size_t kMostStepCounts = 1000;
/// `steps` of [timing] or of a change: one or a list.
std::vector<int> read_step_counts(const Table& table, Errors& errors);

/// Jitter and the models into `timing`, whose means and order are read; adds an error for each that makes no sense there.
void read_timing_models(const Table& table, ProgrammedTiming& timing, Errors& errors);

/// A paced schedule whose mean work, with all that the models add and after each change, is longer than its segment never
/// catches up.
void check_pace(const Table& table, const ProgrammedTiming& timing, Errors& errors);

}  // namespace evenstep::internal
