#pragma once
/// How stiff the tissue is under a tool: K in f(x + d) = f(x) - K d (LocalModel in scene.h).
///
/// A tool t of a grab or a spring and the particles that move, f, have together the stiffness [K_tt K_tf; K_ft K_ff].
/// Instantaneous: K_tt, which for a grab is the sum over the springs from what it holds to what it does not of
/// k (n n' + (1 - L/|d|) (I - n n')), and for a spring its own k. Settled: the Schur complement K_tt - K_tf K_ff^-1 K_ft
/// of the Hessian at rest, other tools where they are; for a spring that is its own stiffness in series with the tissue's.
///
/// A probe touches other particles in every step. Instantaneous: the sum of k (n n' + (1 - r/|d|) (I - n n')) over them.
/// Settled: each in series with the tissue under it, the sum of n n' / (1/k + n' C n), where C is the particle's nodal
/// compliance at rest, a 3 x 3 block of K_ff^-1. That one particle touched yields under the others is neglected, so the sum
/// is at least the stiffness of the settled contact, and equal to it where one particle is touched lightly.

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

/// The nodal compliance of the kMostProbedNodes moving particles nearest to each probe's centre at the start, three systems
/// each. What a probe touches beyond them counts with its instantaneous stiffness.
class ProbeCompliance {
 public:
  /// `in_double`: the sums of the solver are, otherwise they are of floats.
  ProbeCompliance(const TissueScene& scene, const Lattice& lattice, bool in_double);
  /// Cells whose displacements `settled` reads, probe after probe.
  const std::vector<std::uint32_t>& cells() const { return cells_; }
  /// The settled stiffness from the instantaneous one, of a probe of radius `reach_m` displaced by `offset_m`; `displacement_m`
  /// as cells().
  glm::dmat3 settled(std::size_t tool, const glm::dvec3& offset_m, double reach_m,
                     std::span<const std::array<double, 3>> displacement_m,
                     const glm::dmat3& instantaneous_N_per_m) const;

 private:
  struct Node {
    std::size_t at;  // in cells_
    glm::dvec3 rest_m;
    glm::dmat3 compliance_m_per_N;
  };
  std::vector<std::uint32_t> cells_;
  std::vector<ToolCoupling> tools_;
  std::vector<std::vector<Node>> nodes_;  // per tool
  bool in_double_;
};
inline constexpr std::size_t kMostProbedNodes = 16;  ///< 48 systems: two spacings around the centre, and some below

}  // namespace evenstep::internal
