// [[device]] render, as far as it needs something from the scene
#include <fmt/format.h>

#include <algorithm>

#include "src/sections.h"

namespace evenstep::internal {
namespace {

const char* name_of(LocalModel model) {
  return model == LocalModel::settled ? "settled" : model == LocalModel::instantaneous ? "instantaneous" : "none";
}

/// Reads which stiffness the solver must compute. Devices that render with the stiffness of the contact say which; [scene]
/// may ask for one that no device renders.
void read_local_model(ScenarioReading& reading) {
  const Table table = reading.section("scene");
  LocalModel rendered = LocalModel::none;
  for (const DeviceSpec& device : reading.scenario.devices) {
    const auto* local = std::get_if<LocalRender>(&device.render);
    const LocalModel wanted = local ? local->stiffness : LocalModel::none;
    if (wanted == LocalModel::none) continue;
    if (rendered != LocalModel::none && wanted != rendered) {
      reading.errors.add(
          table.place("kind"),
          fmt::format("device '{}' renders with stiffness = \"{}\" and one before it with \"{}\"; a solver reports "
                      "one of them, write the same for both",
                      device.name, name_of(wanted), name_of(rendered)));
    }
    rendered = wanted;
  }
  if (rendered == LocalModel::none) return;
  if (table.has("local_model") && table.text("local_model") != name_of(rendered)) {
    reading.errors.add(
        table.place("local_model"),
        fmt::format("'local_model': \"{}\", but a device renders with stiffness = \"{}\"; remove 'local_model'",
                    table.text("local_model"), name_of(rendered)));
  }
  reading.scenario.scene.local_model = rendered;
}

/// Devices that render the coupling of two hands need a tissue that couples them.
void read_hand_coupling(ScenarioReading& reading) {
  const auto& devices = reading.scenario.devices;
  const auto coupled = std::find_if(devices.begin(), devices.end(), [](const DeviceSpec& device) {
    const auto* local = std::get_if<LocalRender>(&device.render);
    return local && local->coupled;
  });
  if (coupled == devices.end()) return;
  const auto* tissue = std::get_if<TissueScene>(&reading.scenario.scene.body);
  const bool held = tissue && tissue->tools.size() == 2 &&
                    std::none_of(tissue->tools.begin(), tissue->tools.end(),
                                 [](const ToolCoupling& tool) { return tool.kind == CouplingKind::probe; });
  reading.scenario.scene.local_coupling = held;
  if (held) return;
  reading.errors.add(reading.section("scene").place("kind"),
                     fmt::format("device '{}' renders with coupled = true, which is for two hands that hold one tissue; "
                                 "write kind = \"tissue\" and two [[device]] with a grab (coupling \"grab\" or \"spring\"), "
                                 "or remove 'coupled'",
                                 coupled->name));
}

/// Checks that for a device that renders a mode all numbers are given, by the device or by the scene.
void check_modes(ScenarioReading& reading) {
  for (const DeviceSpec& device : reading.scenario.devices) {
    const auto* smith = std::get_if<SmithRender>(&device.render);
    if (!smith || smith_mode(reading.scenario.scene, *smith)) continue;
    reading.errors.add(
        reading.section("scene").place("kind"),
        fmt::format("device '{}' renders \"smith\", a model of one mode, and a scene of this kind does not say which; "
                    "write frequency, damping_ratio and static_stiffness in its 'render'",
                    device.name));
  }
}

}  // namespace

void read_rendering(ScenarioReading& reading) {
  if (!reading.sound("scene") || reading.document.find("scene") == nullptr) return;
  read_local_model(reading);
  read_hand_coupling(reading);
  check_modes(reading);
}

}  // namespace evenstep::internal
