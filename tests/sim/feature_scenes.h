#pragma once
// Small blocks with every combination of the features of a scene.
#include "tissue_scenes.h"

namespace evenstep::test {

struct Has {
  bool regions = false, damping = false, axial_damping = false, gravity = false;
  CouplingKind tool = CouplingKind::grab;
  Method method = Method::symplectic_euler;
};

inline std::string text_of(const Has& has) {
  return std::string(has.regions ? "regions " : "") + (has.damping ? "damping " : "") +
         (has.axial_damping ? "axial damping " : "") + (has.gravity ? "gravity " : "") +
         (has.tool == CouplingKind::grab     ? "grab"
          : has.tool == CouplingKind::spring ? "spring"
                                             : "probe") +
         (has.method == Method::velocity_verlet  ? " Verlet"
          : has.method == Method::implicit_euler ? " implicit Euler"
                                                 : "");
}

/// A tool of the given kind near the top, and one of another kind beside it.
inline std::vector<ToolCoupling> two_tools(CouplingKind kind, double a) {
  const auto tool = [&](CouplingKind which, const glm::dvec3& site) -> ToolCoupling {
    if (which == CouplingKind::grab) return {site * a, 0.6 * a};
    if (which == CouplingKind::spring) return {site * a, 1.1 * a, which, 60, 0.02};
    return {(site + glm::dvec3(0.1, 0.2, 1.5)) * a, 1.8 * a, which, 35};  // touches the top layer from the start
  };
  const CouplingKind other = kind == CouplingKind::grab     ? CouplingKind::spring
                             : kind == CouplingKind::spring ? CouplingKind::probe
                                                            : CouplingKind::grab;
  return {tool(kind, {1, 1, 3}), tool(other, {4, 2, 3})};
}

/// 6 x 4 x 5 sites with a ragged top layer.
inline TissueScene featured_block(const Has& has) {
  TissueScene tissue;
  tissue.lattice = {6, 4, 5};
  tissue.particle_count = 6 * 4 * 5 - 7;
  tissue.spacing_m = 5e-3;
  tissue.particle_mass_kg = 1e-4;
  tissue.stiffness_N_per_m = 20;
  tissue.tools = two_tools(has.tool, tissue.spacing_m);
  tissue.method = has.method;
  if (has.damping) tissue.damping_per_s = 20;
  if (has.axial_damping) tissue.axial_damping_N_s_per_m = 2e-3;
  if (has.gravity) tissue.gravity_m_per_s2 = {0.5, 0, -9.81};
  if (has.regions) tissue.regions = {{{-1, -1, 6e-3}, {12e-3, 1, 1}, 55, 3e-4}, {{8e-3, 4e-3, 0}, {1, 1, 16e-3}, 7, 0.4e-4}};
  return tissue;
}

inline std::vector<Has> every_combination(std::initializer_list<Method> methods = {Method::symplectic_euler,
                                                                                   Method::velocity_verlet}) {
  std::vector<Has> all;
  for (const Method method : methods)
    for (const CouplingKind tool : {CouplingKind::grab, CouplingKind::spring, CouplingKind::probe})
      for (unsigned bits = 0; bits < 16; ++bits)
        all.push_back({(bits & 1) != 0, (bits & 2) != 0, (bits & 4) != 0, (bits & 8) != 0, tool, method});
  return all;
}

/// Each combination is an OpenCL program to build, so not all are tried. In six of the sixteen (none, all, and all but one)
/// every pair of features occurs in each of its four states. The combination with all features has its own test. The other
/// five are shared out so that every method meets each of them with one of the tools, and every tool with one of the
/// methods.
inline bool is_tried(const Has& has) {
  const std::array features{has.regions, has.damping, has.axial_damping, has.gravity};
  const auto count = std::count(features.begin(), features.end(), true);
  const int method = has.method == Method::symplectic_euler ? 0 : has.method == Method::velocity_verlet ? 1 : 2;
  const int share = (method + static_cast<int>(has.tool)) % 3;
  if (count == 0) return share == 2;
  if (count != 3) return false;
  const auto missing = std::find(features.begin(), features.end(), false) - features.begin();
  return share == 0 ? missing < 2 : share == 1 ? missing >= 2 : missing == 1 || missing == 2;
}

}  // namespace evenstep::test
