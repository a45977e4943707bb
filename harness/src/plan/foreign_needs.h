#pragma once
/// What a scenario needs of a solver that the program has registered.

#include <vector>

#include "evenstep/format/scenario.h"

namespace evenstep::internal {

/// The errors of expectations and devices that need a capability which the foreign solver lacks. One solver is made to find
/// out, but only if something needs more than step().
std::vector<Diagnostic> lacking_for_expectations(const Scenario& scenario);

}  // namespace evenstep::internal
