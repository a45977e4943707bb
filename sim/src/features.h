#pragma once
/// Which features of a solver a scene needs. This is decided only here; a feature that the scene does not need has no kernel
/// code, no array and no launch.

#include <array>
#include <optional>
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
  /// How many sums are read for a probe: all of ProbeSums, or only its force.
  std::size_t probe_values() const { return local_model ? kProbeValues : kProbeForces; }
  bool probes() const { return probe[0] || probe[1]; }
  bool grabs() const { return grab[0] || grab[1]; }
  /// Whether there are spring couplings or probes.
  bool tool_forces() const { return spring[0] || spring[1] || probes(); }
};

/// The features that a scene needs; its body must be a tissue.
SceneFeatures features_of(const Scene& scene);
/// The features that a scene needs, and all that change nothing when their coefficients are neutral: with them, tests prove
/// that leaving features out does not change a bit.
SceneFeatures every_feature(const Scene& scene);
/// The features that are left out, in a fixed order.
std::vector<std::string> left_out(const SceneFeatures& features);
/// The scene's features and the one of this name, for the scene's tools. Nullopt if that feature cannot be neutral.
std::optional<SceneFeatures> features_with(const std::string& feature, const Scene& scene);

/// Throws SolverError (unavailable) for a method that the solver does not have.
void check_method(Method method, const std::string& solver);

/// Whether the masses of the particles are needed, and not only their inverses.
bool needs_mass(const SceneFeatures& features, Method method);
/// How many arrays with one scalar per cell a method needs, including those of the energies.
int scalar_arrays(const SceneFeatures& features, Method method);

}  // namespace evenstep::internal
