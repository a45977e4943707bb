#pragma once
/// A map that the program has registered, as any other map.

#include <memory>

#include "evenstep/harness/sizing.h"

namespace evenstep::internal {

/// Throws RunFailure, which names the map, if it cannot be made; its functions throw the same.
std::unique_ptr<SlotMap> foreign_map(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency);

}  // namespace evenstep::internal
