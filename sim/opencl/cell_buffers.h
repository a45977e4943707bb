#pragma once
/// The data of every cell that the kernels read, on the device, and the arguments that all kernels of forces have.

#include <array>

#include "opencl/cl_commands.h"
#include "src/tissue/tissue_solver.h"

namespace evenstep::internal {

/// Whether the method's own kernel moves the grabbed particles.
inline bool needs_holding(const SceneFeatures& features, Method method) {
  return method == Method::symplectic_euler && features.grabs();
}

/// A buffer that the scene does not need is null.
struct CellBuffers {
  CellBuffers(const TissueScene& scene, const Lattice& lattice, const SceneFeatures& features, double substep_s,
              const ClCommands& commands);
  std::size_t chunks() const { return lattice.span / kChunk; }
  bool is_probe(std::size_t tool) const { return scene.tools[tool].kind == CouplingKind::probe; }

  /// Add the arguments for MATERIALS and TOOLS of the kernels' parameters (kernels/springs.cl).
  void add_materials(BoundKernel& kernel) const;
  void add_tools(BoundKernel& kernel) const;
  void set_tools(BoundKernel& kernel, const ToolStates& tools) const;

  const TissueScene& scene;
  const Lattice& lattice;
  const SceneFeatures& features;
  TissueConstants<float> constants;
  ClBuffer active, mobile, holding;  // holding: as mobile, but 2 or 3 where tool 0 or 1 grabs (kernels/advance.cl)
  ClBuffer stiffness, inverse_mass, mass;
  std::array<ClBuffer, kMaxTools> held;
  ClField rest_m;
};

inline cl_float4 float4(const std::array<double, 3>& v) {
  return {{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), 0}};
}
/// Both tools' offsets and velocities, from argument `at` on.
void set_tool_states(BoundKernel& kernel, cl_uint at, const ToolStates& tools);

}  // namespace evenstep::internal
