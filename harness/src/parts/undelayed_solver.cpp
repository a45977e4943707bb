#include "undelayed_solver.h"

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <variant>

#include "evenstep/loop/recorder.h"
#include "evenstep/loop/solver_step.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {
namespace {

/// The position of the device, interpolated between its ticks; before the first and after the last tick the position there.
glm::dvec3 position_at(const Rows<TickRow>& ticks, RealTime at) {
  const auto to_glm = [](const TickRow& tick) {
    const auto [x, y, z] = tick.position_m;
    return glm::dvec3(x, y, z);
  };
  const auto after =
      std::lower_bound(ticks.begin(), ticks.end(), at, [](const TickRow& tick, RealTime t) { return tick.at < t; });
  if (after == ticks.end()) return ticks.empty() ? glm::dvec3(0) : to_glm(ticks.back());
  if (after == ticks.begin() || after->at == at) return to_glm(*after);
  const TickRow& before = *(after - 1);
  const double w = static_cast<double>((at - before.at).ns) / static_cast<double>((after->at - before.at).ns);
  return to_glm(before) + (to_glm(*after) - to_glm(before)) * w;
}

}  // namespace

UndelayedSolver::UndelayedSolver(const Scenario& scenario, std::size_t tool) : tool_(tool) {
  Scene scene = scenario.scene;
  scene.local_model = LocalModel::none;
  scene.variable_step = scene.needs_energy = scene.needs_state_digest = false;
  scene.step_rate = scenario.devices[tool].rate;
  try {
    solver_ = make_solver(scenario.solver, scene, scenario.solver_options);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

Vec3 UndelayedSolver::next(std::span<const glm::dvec3> positions_m) {
  try {
    return to_vec3(solver_->step(positions_m).force_N[tool_]);
  } catch (const SolverError& error) {
    throw run_failure(error);
  }
}

void put_undelayed(const Scenario& scenario, std::vector<DeviceRecord>& devices) {
  if (!costs_little(scenario.scene) && !scenario.needs_undelayed) return;
  for (std::size_t tool = 0; tool < devices.size(); ++tool) {
    UndelayedSolver solver(scenario, tool);
    for (TickRow& tick : devices[tool].ticks) {
      std::array<glm::dvec3, kMaxTools> positions_m;
      for (std::size_t other = 0; other < devices.size(); ++other)
        positions_m[other] = position_at(devices[other].ticks, tick.at);
      tick.undelayed_N = solver.next(std::span(positions_m.data(), devices.size()));
    }
  }
}

}  // namespace evenstep::internal
