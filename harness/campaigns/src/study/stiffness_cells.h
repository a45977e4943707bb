#pragma once
/// The strategies of a search for the largest stable stiffness, one by one, so that shards can divide them.

#include <cstddef>
#include <optional>

#include "evenstep/campaigns/stiffness_limit.h"

namespace evenstep::internal {

/// The record without its limits.
StiffnessLimits stiffness_description(const Scenario& scenario);
/// Of one of the scenario's strategies. Nothing: it was interrupted. Throws RunFailure.
std::optional<StiffnessLimit> stiffness_limit_of(const Scenario& scenario, std::size_t strategy,
                                                 const StudyControl& control);

}  // namespace evenstep::internal
