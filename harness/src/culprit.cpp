#include "culprit.h"

#include <fmt/format.h>

#include <algorithm>

namespace evenstep::internal {
namespace {

/// The first answer that differs. Everything before it, and so everything that it answers, was equal.
struct First {
  RealTime at = kNever;
  std::string text;  ///< empty: it was a part of evenstep's own
};

/// A device is told forces and asked for positions.
First first_of_devices(const Scenario& scenario, const StrategyRecord& a, const StrategyRecord& b) {
  First first;
  for (std::size_t tool = 0; tool < std::min(a.devices.size(), b.devices.size()); ++tool) {
    const auto& mine = a.devices[tool].ticks;
    const auto& other = b.devices[tool].ticks;
    for (std::size_t k = 0; k < std::min(mine.size(), other.size()); ++k) {
      if (mine[k].position_m == other[k].position_m) continue;
      if (mine[k].at >= first.at) break;
      const auto* driver = std::get_if<ForeignDriverSpec>(&scenario.devices[tool].driver);
      first = {mine[k].at, !driver ? ""
                                   : fmt::format("the driver '{}' of \"{}\" gave another position at tick {}",
                                                 driver->part.name, scenario.devices[tool].name, k)};
      break;
    }
  }
  return first;
}

bool same_read(const StrategyRecord& a, const StrategyRecord& b, std::size_t n) {
  for (std::size_t tool = 0; tool < a.devices.size(); ++tool) {
    if (a.devices[tool].steps[n].position_m != b.devices[tool].steps[n].position_m) return false;
  }
  return true;
}
bool same_force(const StrategyRecord& a, const StrategyRecord& b, std::size_t n) {
  for (std::size_t tool = 0; tool < a.devices.size(); ++tool) {
    if (a.devices[tool].steps[n].force_N != b.devices[tool].steps[n].force_N) return false;
  }
  return true;
}

/// A map is told when things happen and asked for slots; a solver gets positions and gives forces.
First first_of_steps(const Scenario& scenario, const StrategyRecord& a, const StrategyRecord& b) {
  const auto* scene = std::get_if<ForeignScene>(&scenario.scene.body);
  const bool own_map = scenario.remap.foreign && a.name == name_of(StrategyKind::foreign);
  const std::size_t steps = std::min(a.steps.size(), b.steps.size());
  for (std::size_t n = 0; n < steps; ++n) {
    const StepRow &mine = a.steps[n], &other = b.steps[n];
    if (mine.begin == other.begin && (mine.read != other.read || mine.mapped != other.mapped))
      return {mine.begin, own_map ? fmt::format("the map '{}' gave another slot for step {}: R(n) = {} ns and {} ns",
                                                scenario.remap.foreign->name, n, mine.read.ns, other.read.ns)
                                  : ""};
    if (mine.begin != other.begin || mine.end != other.end || !same_read(a, b, n)) return {mine.begin, ""};
    if (!same_force(a, b, n))
      return {
          mine.end,
          scene ? fmt::format("the solver '{}' gave another force for the same positions at step {}", scene->name, n) : ""};
  }
  // Forces and times are equal, so what differs is what the solver says of its state.
  if (!scene || a.trace_hash == b.trace_hash) return {};
  return {RealTime{kNever.ns - 1}, fmt::format("the solver '{}' gave another digest of its state", scene->name)};
}

}  // namespace

std::string foreign_culprit(const Scenario& scenario, const StrategyRecord& a, const StrategyRecord& b) {
  const First device = first_of_devices(scenario, a, b), step = first_of_steps(scenario, a, b);
  return device.at <= step.at ? device.text : step.text;
}

}  // namespace evenstep::internal
