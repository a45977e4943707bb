#include "evenstep/harness/run_failure.h"

namespace evenstep {
namespace {

/// The words of [expect_stop] reason.
std::string reason_of(const SolverError& error) {
  switch (error.fault()) {
    case SolverFault::unstable_step:
      return "unstable-step";
    case SolverFault::bad_input:
      return "bad-input";
    case SolverFault::unavailable:
    case SolverFault::bad_scene:
    case SolverFault::out_of_memory:
      return "solver";
  }
  return "solver";
}

}  // namespace

RunFailure run_failure(const SolverError& error, std::int64_t at_step) {
  return RunFailure(reason_of(error), error.what(), error.remedy(), at_step);
}

}  // namespace evenstep
