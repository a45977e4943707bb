#pragma once
/// The force that the scene would have given without any delay: from a second solver that makes a step at each tick of a
/// device, with the position that the tick read.

#include <memory>
#include <span>
#include <vector>

#include "evenstep/format/scenario.h"
#include "evenstep/reports/run_record.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

/// The second solver, for the ticks of one device. Throws RunFailure.
class UndelayedSolver {
 public:
  UndelayedSolver(const Scenario& scenario, std::size_t tool);
  /// The force at the device's next tick, with the positions of all devices then.
  Vec3 next(std::span<const glm::dvec3> positions_m);

 private:
  std::unique_ptr<Solver> solver_;
  std::size_t tool_;
};

/// Sets TickRow::undelayed_N of every device. For a tissue, whose steps are expensive, only if the scenario asks for it; the
/// other tool's position is then interpolated between its own ticks.
void put_undelayed(const Scenario& scenario, std::vector<DeviceRecord>& devices);

}  // namespace evenstep::internal
