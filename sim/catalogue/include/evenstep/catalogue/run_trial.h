#pragma once
/// Runs a trial on its solver twice: step after step in a loop, and launched by the scheduler at irregular times.

#include <atomic>

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// If the solver refuses the scene or is unavailable, that is the result of the cell; any other error of the solver (memory)
/// throws RunFailure. `seed` is that of the irregular schedule. If `interrupted` stops either of the two runs, the result is
/// CellStatus::interrupted.
CaseCell run_cell(const CaseKind& kind, CellSpec cell, std::uint64_t seed, const std::atomic<bool>* interrupted);

}  // namespace evenstep::internal
