#pragma once
#include "evenstep/draw/tissue_mesh.h"

namespace evenstep::test {

inline TissueScene block(std::array<int, 3> lattice) {
  TissueScene tissue;
  tissue.lattice = lattice;
  tissue.particle_count = static_cast<std::int64_t>(lattice[0]) * lattice[1] * lattice[2];
  tissue.spacing_m = 5e-3;
  return tissue;
}

/// A tool of 6 mm at the middle of the top.
inline TissueScene with_tool(TissueScene tissue, CouplingKind kind) {
  const auto [nx, ny, nz] = tissue.lattice;
  tissue.tools = {{0.5 * tissue.spacing_m * glm::dvec3(nx - 1, ny - 1, 2 * (nz - 1)), 6e-3, kind, 100, 0}};
  return tissue;
}

inline ParticleState at_rest(const TissueScene& tissue) {
  return {std::vector<glm::dvec3>(static_cast<std::size_t>(tissue.particle_count)), {}};
}

}  // namespace evenstep::test
