#pragma once
/// How stiff the tissue is under a tool: K in f(x + d) = f(x) - K d (LocalModel in scene.h).
///
/// A tool t of a grab or a spring and the particles that move, f, have together the stiffness [K_tt K_tf; K_ft K_ff].
/// Instantaneous: K_tt, which for a grab is the sum over the springs from what it holds to what it does not of
/// k (n n' + (1 - L/|d|) (I - n n')), and for a spring its own k. Settled: the Schur complement K_tt - K_tf K_ff^-1 K_ft
/// of the Hessian at rest, other tools where they are; for a spring that is its own stiffness in series with the tissue's.

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <span>
#include <vector>

#include "src/lattice.h"

namespace evenstep::internal {

class GrabStiffness {
 public:
  GrabStiffness(const TissueScene& scene, const Lattice& lattice);
  /// Cells whose displacements `of` reads, increasing.
  const std::vector<std::uint32_t>& cells() const { return cells_; }
  /// Instantaneous, of a grab; `displacement_m` as cells().
  glm::dmat3 of(std::size_t tool, std::span<const std::array<double, 3>> displacement_m) const;

 private:
  struct Spring {
    std::size_t held, other;  // in cells_
    glm::dvec3 rest_m;
    double length_m, stiffness_N_per_m;
  };
  std::vector<std::uint32_t> cells_;
  std::vector<std::vector<Spring>> springs_;  // per tool
};

/// Settled, of a grab or a spring: three systems solved by conjugate gradients to 1e-9 of their right-hand sides.
glm::dmat3 settled_stiffness(const TissueScene& scene, const Lattice& lattice, std::size_t tool);

}  // namespace evenstep::internal
