#pragma once
/// How stiff the tissue is under a tool: K in f(x + d) = f(x) - K d (LocalModel in scene.h).
///
/// Grab and spring: a tool t and the free particles f together have the stiffness matrix [K_tt K_tf; K_ft K_ff].
/// Instantaneous: K_tt. For a grab that is the sum of k (n n' + (1 - L/|d|) (I - n n')) over the springs from the particles
/// that it holds to those that it does not; for a spring it is its own k. Settled: the Schur complement
/// K_tt - K_tf K_ff^-1 K_ft of the Hessian at rest, with the other tools held still; for a spring that is its own stiffness
/// in series with that of the tissue. The coupling of two tools t and s is the block of the same matrix that stands beside
/// it: instantaneous K_ts, which is 0 unless springs go from one lump to the other, settled K_ts - K_tf K_ff^-1 K_fs.
///
/// A probe touches different particles in every step. Instantaneous: the sum of k (n n' + (1 - r/|d|) (I - n n')) over
/// them. Settled: the sum of n n' / (1/k + n' C n), each particle in series with the tissue under it, where C is the
/// particle's nodal compliance at rest, a 3 x 3 block of K_ff^-1. This neglects that a touched particle also yields under
/// the load of the others, so the sum is at least the stiffness of the settled contact. The two are equal if a single
/// particle is touched lightly.

#include <cstdint>
#include <glm/mat3x3.hpp>
#include <span>
#include <vector>

#include "src/tissue/lattice.h"

namespace evenstep::internal {

class GrabStiffness {
 public:
  GrabStiffness(const TissueScene& scene, const Lattice& lattice);
  /// The cells whose displacements `of` needs, increasing.
  const std::vector<std::uint32_t>& cells() const { return cells_; }
  /// The instantaneous stiffness of a grab; `displacement_m` has one entry per entry of cells().
  glm::dmat3 of(std::size_t tool, std::span<const std::array<double, 3>> displacement_m) const;
  /// The instantaneous coupling of a grab to the other grab: from the springs whose other end that grab holds.
  glm::dmat3 coupling(std::size_t tool, std::span<const std::array<double, 3>> displacement_m) const;

 private:
  struct Spring {
    std::size_t held, other;  // positions in cells_
    bool to_tool;             // the spring's other end is held by the other tool
    glm::dvec3 rest_m;
    double length_m, stiffness_N_per_m;
  };
  static glm::dvec3 between(const Spring& spring, std::span<const std::array<double, 3>> displacement_m);

  std::vector<std::uint32_t> cells_;
  std::vector<std::vector<Spring>> springs_;  // per tool
};

/// The settled stiffness of a grab or a spring: three systems, solved by conjugate gradients to 1e-9 of their right-hand
/// sides.
glm::dmat3 settled_stiffness(const TissueScene& scene, const Lattice& lattice, std::size_t tool);
/// How the settled force on `tool` follows `other`; both are grabs or springs.
glm::dmat3 settled_coupling(const TissueScene& scene, const Lattice& lattice, std::size_t tool, std::size_t other);

/// The nodal compliances of the kMostProbedNodes mobile particles nearest to each probe's centre at the start, from three
/// systems each. Any other particle that a probe touches counts with its instantaneous stiffness.
class ProbeCompliance {
 public:
  /// `in_double`: whether the solver computes its sums in double rather than float.
  ProbeCompliance(const TissueScene& scene, const Lattice& lattice, bool in_double);
  /// The cells whose displacements `settled` needs, probe after probe.
  const std::vector<std::uint32_t>& cells() const { return cells_; }
  /// Turns the instantaneous stiffness of a probe of radius `reach_m`, displaced by `offset_m`, into the settled one;
  /// `displacement_m` has one entry per entry of cells().
  glm::dmat3 settled(std::size_t tool, const glm::dvec3& offset_m, double reach_m,
                     std::span<const std::array<double, 3>> displacement_m, const glm::dmat3& instantaneous_N_per_m) const;

 private:
  struct Node {
    std::size_t at;  // position in cells_
    glm::dvec3 rest_m;
    glm::dmat3 compliance_m_per_N;
  };
  std::vector<std::uint32_t> cells_;
  std::vector<ToolCoupling> tools_;
  std::vector<std::vector<Node>> nodes_;  // per tool
  bool in_double_;
};
inline constexpr std::size_t kMostProbedNodes = 16;  ///< 48 systems: two spacings around the centre, and some below it

}  // namespace evenstep::internal
