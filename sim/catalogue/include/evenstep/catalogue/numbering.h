#pragma once
/// A scene with its axes exchanged and mirrored: S18 of the catalogue. Every particle and spring gets a different number and
/// every sum a different order; in exact arithmetic the result is the same.

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// Axis a of the new lattice is axis `from[a]` of the old one, in the opposite direction if `mirrored[a]`.
struct Numbering {
  std::array<int, 3> from{0, 1, 2};
  std::array<bool, 3> mirrored{};
  /// A displacement, velocity or force in the new axes.
  glm::dvec3 vector(const glm::dvec3& old) const;
  /// The site in the new lattice that corresponds to a site of `old`.
  std::size_t site(const TissueScene& old, std::size_t site) const;
  /// The whole scene in the new axes. Its lattice must be full: the mirror image of a lattice that is cut lacks other sites.
  TissueScene scene(const TissueScene& old) const;
};
/// The 47 numberings other than the scene's own.
std::vector<Numbering> all_numberings();

/// Value: steps. Metric `numbering_difference`: the largest difference between eleven numberings (every exchange of axes,
/// plain and with all axes mirrored) in displacements divided by the spacing L, velocities divided by L sqrt(k / m) and
/// forces on the hands divided by k L. These are the scales at which the length of a spring is rounded; the state itself
/// would give no scale for a block at rest.
std::unique_ptr<Trial> make_numbering(const CellSpec& cell);

}  // namespace evenstep::internal
