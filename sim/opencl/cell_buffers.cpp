#include "opencl/cell_buffers.h"

namespace evenstep::internal {

CellBuffers::CellBuffers(const TissueScene& of_scene, const Lattice& of_lattice, const SceneFeatures& of_features,
                         double substep_s, const ClCommands& commands)
    : scene(of_scene),
      lattice(of_lattice),
      features(of_features),
      constants(scene, lattice, substep_s),
      active(commands.buffer_of(std::vector<float>(lattice.active.begin(), lattice.active.end()))),
      mobile(commands.buffer_of(std::vector<float>(lattice.mobile.begin(), lattice.mobile.end()))) {
  if (needs_holding(features, scene.method)) {
    std::vector<float> values(lattice.mobile.begin(), lattice.mobile.end());
    for (std::size_t tool = 0; tool < scene.tools.size(); ++tool)
      if (features.grab[tool])
        for (const std::uint32_t cell : lattice.held[tool]) values[cell] = 2 + static_cast<float>(tool);
    holding = commands.buffer_of(values);
  }
  if (features.regions) {
    const MaterialArrays<float> materials(scene, lattice);
    stiffness = commands.buffer_of(materials.stiffness);
    inverse_mass = commands.buffer_of(materials.inverse_mass);
    if (needs_mass(features, scene.method)) mass = commands.buffer_of(materials.mass);
  }
  for (std::size_t tool = 0; tool < kMaxTools; ++tool)
    if (features.spring[tool]) held[tool] = commands.buffer_of(held_cells<float>(scene, lattice, tool));
  if (!features.probes()) return;
  const auto rest = [&](int component) { return commands.buffer_of(rest_positions<float>(scene, lattice, component)); };
  rest_m = {rest(0), rest(1), rest(2)};
}

void CellBuffers::add_materials(BoundKernel& kernel) const {
  if (features.regions) kernel.add(stiffness, inverse_mass);
}

void CellBuffers::add_tools(BoundKernel& kernel) const {
  for (std::size_t tool = 0; tool < kMaxTools; ++tool)
    if (features.spring[tool]) kernel.add(held[tool]);
  if (features.probes()) kernel.add(rest_m);
  if (!features.tool_forces()) return;
  const cl_float4 none{};
  kernel.tools_at = kernel.next();
  kernel.add(none, none, none, none);
}

void CellBuffers::set_tools(BoundKernel& kernel, const ToolStates& tools) const {
  if (features.tool_forces()) set_tool_states(kernel, kernel.tools_at, tools);
}

void set_tool_states(BoundKernel& kernel, cl_uint at, const ToolStates& tools) {
  for (const ToolState& tool : tools) {
    kernel.set(at++, float4(tool.offset_m));
    kernel.set(at++, float4(tool.velocity_m_per_s));
  }
}

}  // namespace evenstep::internal
