#pragma once
/// One scene with its axes exchanged and mirrored: S18 of the catalogue. Every particle and spring gets another number, every
/// sum another order, and in real numbers the answer is the same.

#include "evenstep/catalogue/trial.h"

namespace evenstep::internal {

/// Axis a of the new lattice is axis `from[a]` of the old one, run through backwards where `mirrored[a]`.
struct Numbering {
  std::array<int, 3> from{0, 1, 2};
  std::array<bool, 3> mirrored{};
  /// A displacement, velocity or force.
  glm::dvec3 vector(const glm::dvec3& old) const;
  /// Site in the new lattice of a site of `old`.
  std::size_t site(const TissueScene& old, std::size_t site) const;
  /// All of the scene, of a lattice that is full: a mirror image of one that is cut lacks other sites.
  TissueScene scene(const TissueScene& old) const;
};
/// The 47 that are not the scene's own.
std::vector<Numbering> all_numberings();

/// Value: steps. Metric `numbering_difference`: largest difference of eleven numberings (every exchange of axes, as it is and
/// with all of them mirrored) in displacements over the spacing L, velocities over L sqrt(k / m) and forces on the hands over
/// k L. These are what a spring's length is rounded in: over the state itself a block at rest would have no scale at all.
std::unique_ptr<Trial> make_numbering(const CellSpec& cell);

}  // namespace evenstep::internal
