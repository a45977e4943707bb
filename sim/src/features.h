#pragma once
/// What of a solver a scene needs, decided in this one place: what a scene lacks has no kernel code, no array and no launch.

#include <array>
#include <string>
#include <vector>

#include "evenstep/sim/scene.h"
#include "evenstep/sim/solver.h"

namespace evenstep::internal {

inline constexpr std::size_t kProbeForces = 3, kProbeValues = 14;

struct SceneFeatures {
  bool regions = false;
  bool damping = false;  ///< mass-proportional
  bool axial_damping = false;
  bool gravity = false;
  std::array<bool, kMaxTools> grab{}, spring{}, probe{};  ///< per tool
  bool variable_step = false;
  bool energy = false;
  bool digest = false;
  bool local_model = false;
  bool fixed = false;
  /// Sums that a probe is read by: ProbeSums, or its force alone.
  std::size_t probe_values() const { return local_model ? kProbeValues : kProbeForces; }
  bool probes() const { return probe[0] || probe[1]; }
  /// Couplings or probes.
  bool tool_forces() const { return spring[0] || spring[1] || probes(); }
};

/// Of a scene whose body is a tissue.
SceneFeatures features_of(const Scene& scene);
/// All that change nothing where their coefficients are neutral: for the proof that leaving them out changes no bit.
SceneFeatures every_feature(const Scene& scene);
/// What is not there, in a fixed order.
std::vector<LeftOut> left_out(const SceneFeatures& features, bool opencl);

/// Throws SolverError (unavailable) for a method that the solver does not have.
void check_method(Method method, const std::string& solver);

/// Whether the masses of regions are needed, not only their inverse.
bool needs_mass(const SceneFeatures& features, Method method);
/// Arrays of one scalar per cell that a method needs, the energies among them.
int scalar_arrays(const SceneFeatures& features, Method method);

}  // namespace evenstep::internal
