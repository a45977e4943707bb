#pragma once
/// The data of every cell that the loops read, in host memory: for the cpu solvers, and for what an OpenCL solver computes
/// once on the host.

#include <deque>
#include <utility>
#include <vector>

#include "cpu/cell_loops.h"

namespace evenstep::internal {

template <class Real>
class HostCells {
 public:
  HostCells(const TissueScene& scene, const Lattice& lattice, const SceneFeatures& features) : first_(lattice.first) {
    arrays_.active = keep({lattice.active.begin(), lattice.active.end()});
    arrays_.mobile = keep({lattice.mobile.begin(), lattice.mobile.end()});
    arrays_.inverse_mass = arrays_.mass = arrays_.mobile;
    arrays_.offset = lattice.offset;
    if (features.regions) {
      MaterialArrays<Real> materials(scene, lattice);
      arrays_.stiffness = keep(std::move(materials.stiffness));
      arrays_.inverse_mass = keep(std::move(materials.inverse_mass));
      if (needs_mass(features, scene.method)) arrays_.mass = keep(std::move(materials.mass));
    }
    for (std::size_t tool = 0; tool < kMaxTools; ++tool)
      if (features.spring[tool]) arrays_.held[tool] = keep(held_cells<Real>(scene, lattice, tool));
    if (!features.probes()) return;
    const auto rest_m = [&](int component) { return keep(rest_positions<Real>(scene, lattice, component)); };
    arrays_.rest_m = {rest_m(0), rest_m(1), rest_m(2)};
  }
  HostCells(const HostCells&) = delete;
  HostCells& operator=(const HostCells&) = delete;
  const CellArrays<Real>& arrays() const { return arrays_; }

 private:
  /// Keeps an array and returns a pointer to the lattice's first cell in it.
  const Real* keep(std::vector<Real> cells) { return kept_.emplace_back(std::move(cells)).data() + first_; }

  std::size_t first_;
  std::deque<std::vector<Real>> kept_;
  CellArrays<Real> arrays_;
};

}  // namespace evenstep::internal
