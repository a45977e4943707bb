#pragma once
/// Why a run stopped before its end.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

#include "evenstep/sim/solver.h"

namespace evenstep {

/// A run that could not go on: solver, device, limit. `reason` is one of [expect_stop]'s words.
class RunFailure : public std::runtime_error {
 public:
  RunFailure(std::string why, const std::string& what, std::string cure, std::int64_t at_step = -1)
      : std::runtime_error(what), reason(std::move(why)), remedy(std::move(cure)), step(at_step) {}
  std::string reason;  ///< "unstable-step", "diverged", "bad-input", "solver", "device", "limit"
  std::string remedy;
  std::int64_t step;
};

/// A solver's error as the run's; `at_step`: -1 before the first one.
RunFailure run_failure(const SolverError& error, std::int64_t at_step = -1);

}  // namespace evenstep
