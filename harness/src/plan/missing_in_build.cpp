#include <fmt/format.h>

#include "evenstep/device/inverse3/inverse3_socket.h"
#include "evenstep/draw/canvas.h"
#include "evenstep/harness/run.h"
#include "evenstep/sim/busy_device.h"
#include "evenstep/time/build_option.h"

namespace evenstep {
namespace {

Diagnostic missing_at(const Scenario& scenario, const Place& place, std::string message) {
  if (place.file.empty()) return {scenario.file, 0, 0, std::move(message)};
  return {place.file, place.line, place.column, std::move(message)};
}

/// What a real device with this driver needs; nullptr if it is there.
const BuildOption* option_missing_for(const DriverSpec& driver) {
  if (std::holds_alternative<Inverse3Spec>(driver)) return built_with_inverse3() ? nullptr : &build_option::kInverse3;
  const bool hid = std::holds_alternative<ReferenceSpec>(driver) || std::holds_alternative<PidSpec>(driver);
  return hid && !built_with_hidapi() ? &build_option::kHidapi : nullptr;
}

}  // namespace

std::vector<Diagnostic> missing_in_build(const Scenario& scenario, ClockKind clock,
                                         const std::vector<DeviceBinding>& bindings) {
  std::vector<Diagnostic> missing;
  if (scenario.case_spec) return missing;  // its cells say what is unavailable, beside those that are not
  const auto add = [&](const Place& place, std::string message) {
    missing.push_back(missing_at(scenario, place, std::move(message)));
  };
  if (scenario.solver == SolverKind::opencl && std::holds_alternative<TissueScene>(scenario.scene.body) &&
      !built_with_opencl())
    add(scenario.solver_place,
        fmt::format("'solver': \"opencl\": {}", refusal_without(build_option::kOpenCl, kInsteadOfOpenCl)));
  if (clock != ClockKind::wall) return missing;
  const TimingSpec& timing = scenario.timing;
  if (timing.work == VisualizationWork::render && !built_with_drawing())
    add(timing.work_place,
        fmt::format("'visualization': \"render\" draws: {}", refusal_without(build_option::kDraw, kInsteadOfDrawing)));
  if (timing.work == VisualizationWork::burn && !built_with_opencl())
    add(timing.work_place, fmt::format("'visualization': \"burn\" keeps the compute device busy: {}",
                                       refusal_without(build_option::kOpenCl, kInsteadOfBurning)));
  for (std::size_t tool = 0; tool < scenario.devices.size(); ++tool) {
    const DeviceSpec& device = scenario.devices[tool];
    for (const DeviceBinding& binding : bindings) {
      if (binding.name.empty() ? tool != 0 : binding.name != device.name) continue;
      if (const BuildOption* const option = option_missing_for(device.driver))
        add(device.driver_place, fmt::format("--device {}={}: {}", device.name, binding.path,
                                             refusal_without(*option, "leave --device out, which simulates it")));
    }
  }
  return missing;
}

}  // namespace evenstep
