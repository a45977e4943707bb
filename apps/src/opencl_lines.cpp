#include "opencl_lines.h"

#include <spdlog/spdlog.h>

#include "evenstep/sim/opencl_devices.h"

namespace evenstep::app {
namespace {

std::size_t chosen_of(const Scenario& scenario) {
  return choose_opencl(opencl_devices(), scenario.solver_options.opencl_device, scenario.solver_options.prefer_gpu);
}

}  // namespace

bool uses_opencl(const Scenario& scenario) {
  return !scenario.case_spec && scenario.solver == SolverKind::opencl &&
         std::holds_alternative<TissueScene>(scenario.scene.body);
}

std::string opencl_line(const Scenario& scenario) {
  if (!uses_opencl(scenario)) return "";
  try {
    return opencl_text(opencl_devices(), chosen_of(scenario));
  } catch (const SolverError& error) {
    return std::string("none: ") + error.what() + "; " + error.remedy();
  }
}

void warn_of_idle_gpu(const Scenario& scenario) {
  static bool said = false;
  if (said || !uses_opencl(scenario)) return;
  try {
    const std::string text = idle_gpu_text(opencl_devices(), chosen_of(scenario));
    if (text.empty()) return;
    spdlog::warn("{}", text);
    said = true;
  } catch (const SolverError&) {  // the solver itself says so
  }
}

}  // namespace evenstep::app
