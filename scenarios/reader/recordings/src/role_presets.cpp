// What engines call their steps and their drawing. Each row is read from the public source that it names.
#include "evenstep/recordings/roles.h"

namespace evenstep {
namespace {

constexpr RolePreset kPresets[] = {
    {"unity", "^PlayerLoop$", "^(Camera\\.Render|PostLateUpdate\\.FinishFrameRendering)$",
     "^FixedUpdate\\.PhysicsFixedUpdate$", "", "https://docs.unity3d.com/Manual/profiler-markers.html"},
    {"godot", "", "^RenderingServer::(sync|draw)$", "^Physics Step$", "",
     "https://github.com/godotengine/godot, main/main.cpp, the zones of Main::iteration for Tracy"},
    {"unreal", "^FEngineLoop::Tick$", "^FDeferredShadingSceneRenderer", "^TG_(Start|During|End)Physics$",
     "^TG_StartPhysics$",
     "Unreal Insights, TimingInsights.ExportTimingEvents: timers of a frame, of its tick groups, and the "
     "SCOPED_NAMED_EVENTs of "
     "the renderer (Engine/Source/Runtime/Renderer/Private/BasePassRendering.cpp and others)"},
    {"mujoco", "", "^mj[rv]_(render|updateScene)$", "^mj_step$", "",
     "https://mujoco.readthedocs.io/en/stable/APIreference/APIfunctions.html"},
    {"pytorch", "^ProfilerStep#", "", "kernel:.", "", "https://docs.pytorch.org/docs/stable/profiler.html"},
    {"isaac", "", "(Renderer\\.render|Camera\\.update|SimulationContext\\.render)$", "SimulationContext\\.step$", "",
     "https://github.com/isaac-sim/IsaacLab, scripts/benchmarks/nsys_trace.json"},
};

}  // namespace

std::span<const RolePreset> role_presets() { return kPresets; }

Roles with_preset(Roles roles, const std::string& name) {
  for (const RolePreset& preset : kPresets) {
    if (name != preset.name) continue;
    const auto take = [](std::string& given, const char* preset_text) {
      if (given.empty()) given = preset_text;
    };
    roles.optional = roles.unset();
    // A step that the user names has no begin that the preset knows.
    if (roles.step.empty()) take(roles.step_begin, preset.step_begin);
    take(roles.segment, preset.segment);
    take(roles.visualization, preset.visualization);
    take(roles.step, preset.step);
  }
  return roles;
}

}  // namespace evenstep
