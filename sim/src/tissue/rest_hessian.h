#pragma once
/// The Hessian of the energy at rest with respect to the particles that move: k n n' for every spring, and k I for every
/// coupling, whose tool is held still. Arrays have one entry per cell and are 0 where a particle does not move.

#include <glm/mat3x3.hpp>
#include <vector>

#include "src/tissue/lattice.h"
#include "src/tissue/materials.h"

namespace evenstep::internal {

class RestHessian {
 public:
  using Cells = std::vector<glm::dvec3>;

  RestHessian(const TissueScene& scene, const Lattice& lattice);
  const std::vector<std::size_t>& mobile() const { return mobile_; }  ///< cells, increasing
  std::size_t neighbour(std::size_t cell, std::size_t s) const {
    return cell + static_cast<std::size_t>(lattice_.offset[s]);
  }
  /// k n n' of the spring from an active cell to its active neighbour s.
  glm::dmat3 spring(std::size_t cell, std::size_t s) const;
  double coupling_N_per_m(std::size_t cell) const { return coupling_N_per_m_[cell]; }

  /// y = H x for the cells that move; the other entries of y are not changed.
  void apply(const Cells& x, Cells& y) const;
  struct Solution {
    Cells x;
    bool found;  ///< whether H x is the load, to 1e-6 of it
  };
  /// Solves H x = load by conjugate gradients, to 1e-9. If a part of the tissue is free, the matrix is singular: a load in
  /// its range then has many solutions, of which the result is one; any other load has none.
  Solution solve(const Cells& load) const;

 private:
  Cells inverse_diagonal() const;
  double dot(const Cells& a, const Cells& b) const;

  const Lattice& lattice_;
  Materials materials_;
  std::vector<std::size_t> mobile_;
  std::vector<double> coupling_N_per_m_;
};

}  // namespace evenstep::internal
