#pragma once
/// One row per strategy: its plan before the run, its map, its links and how it is drawn. What the rest of the program needs
/// to know about it is in StrategyTraits (format/scenario.h).

#include <memory>
#include <vector>

#include "evenstep/harness/sizing.h"
#include "evenstep/loop/exchange.h"
#include "evenstep/reports/run_record.h"

namespace evenstep::internal {

struct Strategy {
  StrategyKind kind;
  StrategyPlan (*plan)(const Scenario& scenario, StrategyKind kind);
  std::unique_ptr<SlotMap> (*map)(const MapSetup& setup, Duration lead, const AdaptiveLatency& latency);
  /// Sets what its reads and forces do if nothing is there for them, and its filters; the rest of `link` is set already.
  void (*link)(const RemapSpec& remap, LinkSpec& link);
  LineLook look;
};
const Strategy& strategy_of(StrategyKind kind);

/// What each device will miss in a run with this plan.
std::vector<RunningUnderruns> underruns_of(const Scenario& scenario, const MapSetup& setup, const StrategyPlan& plan);

}  // namespace evenstep::internal
