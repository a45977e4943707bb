#pragma once
/// Which material every particle is of.

#include <cstdint>
#include <vector>

#include "evenstep/sim/scene.h"
#include "src/lattice.h"

namespace evenstep::internal {

/// A spring between two materials: the mean, in this order of operations in every solver.
template <class Real>
constexpr Real spring_stiffness(Real a, Real b) {
  return (a + b) * Real{0.5};
}

class Materials {
 public:
  Materials(const TissueScene& scene, const Lattice& lattice);
  /// Of an active cell.
  double stiffness_N_per_m(std::size_t cell) const { return stiffness_N_per_m_[index(cell)]; }
  double mass_kg(std::size_t cell) const { return mass_kg_[index(cell)]; }

 private:
  std::size_t index(std::size_t cell) const { return region_.empty() ? 0 : region_[cell]; }
  std::vector<std::uint8_t> region_;  // per cell: 0 the scene's own material, r + 1 region r; empty without regions
  std::vector<double> stiffness_N_per_m_, mass_kg_;
};

}  // namespace evenstep::internal
