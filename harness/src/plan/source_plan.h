#pragma once
/// What a source adds to the plan of a strategy: how its forces are played, and the room that those on their way need.

#include "evenstep/harness/sizing.h"
#include "evenstep/loop/exchange.h"

namespace evenstep::internal {

/// Makes the ring of forces large enough for a source, or for a strategy that plays more than one force at a time; of one
/// that plays chunks, sets its least_entries.
void add_room(const Scenario& scenario, StrategyPlan& plan);

/// How the device plays its forces; empty: as ForceSchedule does.
std::optional<SourceForces> source_forces(const Scenario& scenario, const StrategyPlan& plan, Emission emission);

/// How far back the forces that a tick plays may lie; of an average, those that count for a billionth. `polyphase` reaches
/// beyond its taps where the last of them is missing: to the force before it that is there.
Duration memory_of(const SourceForces& source, const Scenario& scenario, const StrategyPlan& plan);

}  // namespace evenstep::internal
