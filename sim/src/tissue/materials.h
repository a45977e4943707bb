#pragma once
/// The material of every particle.

#include <cstdint>
#include <vector>

#include "evenstep/sim/scene.h"
#include "src/tissue/lattice.h"

namespace evenstep::internal {

/// The stiffness of a spring between two materials: their mean, computed in this order of operations by every solver.
template <class Real>
constexpr Real spring_stiffness(Real a, Real b) {
  return (a + b) * Real{0.5};
}

class Materials {
 public:
  Materials(const TissueScene& scene, const Lattice& lattice);
  /// The material of a cell, which must be active.
  double stiffness_N_per_m(std::size_t cell) const { return stiffness_N_per_m_[index(cell)]; }
  double mass_kg(std::size_t cell) const { return mass_kg_[index(cell)]; }

 private:
  std::size_t index(std::size_t cell) const { return region_.empty() ? 0 : region_[cell]; }
  std::vector<std::uint8_t> region_;  // per cell: 0 for the scene's own material, r + 1 for region r; empty without regions
  std::vector<double> stiffness_N_per_m_, mass_kg_;
};

}  // namespace evenstep::internal
