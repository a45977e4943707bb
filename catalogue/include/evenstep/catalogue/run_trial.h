#pragma once
/// A trial on its solver, twice: step after step in a loop, and launched by the scheduler at irregular times.

#include <atomic>

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// What a solver refuses is the cell's result; throws RunFailure where it is neither refused nor unavailable (memory).
/// `seed`: of the irregular schedule. Stopped by `interrupted`, whichever of the two runs it is in: CellStatus::interrupted.
CaseCell run_cell(const CaseKind& kind, const CellSpec& cell, std::uint64_t seed, const std::atomic<bool>* interrupted);

}  // namespace evenstep::internal
