#include "src/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace evenstep::internal {

SceneFeatures features_of(const Scene& scene) {
  const auto& tissue = std::get<TissueScene>(scene.body);
  SceneFeatures features;
  features.regions = !tissue.regions.empty();
  features.damping = tissue.damping_per_s != 0;
  features.axial_damping = tissue.axial_damping_N_s_per_m != 0;
  features.gravity = tissue.gravity_m_per_s2 != glm::dvec3(0);
  for (std::size_t tool = 0; tool < std::min<std::size_t>(tissue.tools.size(), kMaxTools); ++tool) {
    features.grab[tool] = tissue.tools[tool].kind == CouplingKind::grab;
    features.spring[tool] = tissue.tools[tool].kind == CouplingKind::spring;
    features.probe[tool] = tissue.tools[tool].kind == CouplingKind::probe;
  }
  features.variable_step = scene.variable_step;
  features.energy = scene.needs_energy;
  features.digest = scene.needs_state_digest;
  features.local_model = scene.local_model != LocalModel::none;
  features.fixed = tissue.fixed.any();
  return features;
}

SceneFeatures every_feature(const Scene& scene) {
  SceneFeatures features = features_of(scene);
  features.regions = features.damping = features.axial_damping = features.gravity = true;
  features.spring = features.probe = {true, true};
  features.variable_step = features.energy = features.digest = true;
  return features;
}

std::vector<std::string> left_out(const SceneFeatures& features) {
  const auto none = [](const std::array<bool, kMaxTools>& tools) { return !tools[0] && !tools[1]; };
  const auto tool = [&](std::size_t n) { return features.grab[n] || features.spring[n] || features.probe[n]; };
  std::vector<std::string> all;
  for (const auto& [absent, name] :
       {std::pair{!features.regions, "regions"}, std::pair{!features.damping, "damping"},
        std::pair{!features.axial_damping, "axial damping"}, std::pair{!features.gravity, "gravity"},
        std::pair{!features.fixed, "fixed particles"}, std::pair{!tool(0), "tools"},
        std::pair{tool(0) && !tool(1), "second tool"}, std::pair{none(features.grab), "grab"},
        std::pair{none(features.spring), "spring coupling"}, std::pair{none(features.probe), "probe"},
        std::pair{!features.local_model, "local model"}, std::pair{!features.variable_step, "variable step"},
        std::pair{!features.energy, "energy"}, std::pair{!features.digest, "state digest"}}) {
    if (absent) all.emplace_back(name);
  }
  return all;
}

std::optional<SceneFeatures> features_with(const std::string& feature, const Scene& scene) {
  SceneFeatures features = features_of(scene);
  const std::size_t tools = std::min<std::size_t>(std::get<TissueScene>(scene.body).tools.size(), kMaxTools);
  const std::array<bool, kMaxTools> there{tools > 0, tools > 1};
  if ((feature == "spring coupling" || feature == "probe") && tools == 0) return std::nullopt;
  if (feature == "spring coupling") features.spring = there;
  if (feature == "probe") features.probe = there;
  const std::pair<const char*, bool*> flags[] = {{"regions", &features.regions},
                                                 {"damping", &features.damping},
                                                 {"axial damping", &features.axial_damping},
                                                 {"gravity", &features.gravity},
                                                 {"energy", &features.energy},
                                                 {"local model", &features.local_model},
                                                 {"state digest", &features.digest},
                                                 {"variable step", &features.variable_step}};
  for (const auto& [name, flag] : flags) *flag = *flag || feature == name;
  if (left_out(features) == left_out(features_of(scene))) return std::nullopt;
  return features;
}

void check_method(Method method, const std::string& solver) {
  if (method == Method::symplectic_euler || method == Method::velocity_verlet || method == Method::implicit_euler) return;
  const char* const names[] = {"symplectic Euler", "velocity Verlet",   "the classical Runge-Kutta method",
                               "implicit Euler",   "implicit midpoint", "vertex block descent"};
  throw SolverError(SolverFault::unavailable,
                    fmt::format("the solver '{}' does not have {}", solver, names[static_cast<std::size_t>(method)]),
                    "symplectic Euler, velocity Verlet, implicit Euler, or the solver 'cpu'");
}

bool needs_mass(const SceneFeatures& features, Method method) {
  const bool is_explicit = method == Method::symplectic_euler || method == Method::velocity_verlet || method == Method::rk4;
  return features.regions && (features.energy || !is_explicit);
}

int scalar_arrays(const SceneFeatures& features, Method method) {
  int arrays = 3 * 3 + 2;  // displacement twice and velocity, or displacement, velocity and acceleration; active and mobile
  if (method == Method::velocity_verlet || features.axial_damping) arrays += 3;  // the velocity twice
  if (features.regions) arrays += 2;                                             // stiffness and inverse mass
  if (needs_mass(features, method)) arrays += 1;
  if (method == Method::rk4) arrays += 5 * 3;  // two stages, a slope, two sums
  if (method == Method::implicit_euler || method == Method::implicit_midpoint)
    arrays += 5 * 3 + 2;                                            // cpu/methods/implicit.cpp
  if (method == Method::vertex_block_descent) arrays += 2 * 3 + 1;  // start, guess; moves and lists
  arrays += features.spring[0] + features.spring[1];
  if (features.probes()) arrays += 3;  // rest positions
  if (features.energy) arrays += features.gravity ? 2 : 1;
  return arrays;
}

}  // namespace evenstep::internal
