#pragma once
/// [[device]] render as it is written: how the force of a tick is computed from its scheduled record (device/renderer.h).
/// A run uses LinkSpec::render (loop/exchange.h), in which every number is known.

#include <optional>
#include <variant>

#include "evenstep/device/renderer.h"
#include "evenstep/sim/scene.h"

namespace evenstep {

/// kind = "force": the scheduled force itself.
struct ForceRender {};

/// kind = "local" and "device_spring": the law of the contact answers the hand between two steps.
struct LocalRender {
  std::optional<double> alpha = 1.0;                 ///< empty: automatic
  LocalModel stiffness = LocalModel::instantaneous;  ///< which stiffness the solver computes
  bool knows_gap = true;                             ///< false only for comparison: the gap is then not used
  /// The largest stiffness with which a contact is played. by_law: as much as the law allows for the hand
  /// (stiffness_laws.h).
  struct Cap {
    enum class Kind { none, by_law, fixed } kind = Kind::none;
    double fixed_N_per_m = 0;
  } cap;
  bool by_device = false;  ///< device_spring: the device renders it as its own springs, as far as it can
  bool coupled = false;    ///< the force follows the other hand, too
  StiffnessPart part = StiffnessPart::all;
};

/// A model of the tissue with one mode, as the tool feels it: a mass between two equal springs.
struct TissueMode {
  std::optional<double> frequency_Hz;  ///< of the mass while the tool is held still
  std::optional<double> damping_ratio;
  std::optional<double> static_N_per_m;  ///< stiffness felt at rest; each spring has twice that
};

/// kind = "smith": a model of the tissue's mode runs at the device.
struct SmithRender {
  TissueMode mode;      ///< values that are not given are taken from the scene
  double factor = 1.1;  ///< on the stiffness of both springs of the model
};

using RenderSpec = std::variant<ForceRender, LocalRender, SmithRender>;

/// The model of a device that renders `smith`. Empty if one of its numbers is given neither by the device nor by the scene.
std::optional<SpringMode> smith_mode(const Scene& scene, const SmithRender& render);

}  // namespace evenstep
