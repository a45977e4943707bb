#pragma once
/// The numbers of the linear system of an implicit method, the same for every solver.

#include <limits>
#include <vector>

#include "cpu/cell_forces.h"

namespace evenstep::internal {

/// The constants of A = M + q C + q^2 K divided by the scene's particle mass m: inertia = 1 + q d of a particle of that
/// mass, stiffness = q^2 k / m, axial = c / (k q).
template <class Real>
struct SystemConstants {
  SystemConstants() = default;
  SystemConstants(const TissueScene& scene, double q)
      : inertia(static_cast<Real>(1 + q * scene.damping_per_s)),
        stiffness(static_cast<Real>(q * q * scene.stiffness_N_per_m / scene.particle_mass_kg)),
        axial(static_cast<Real>(scene.axial_damping_N_s_per_m / scene.stiffness_N_per_m / q)) {}
  /// M + q C of a particle: the drag q d is that of mass 1 on every particle that moves. (Exactly `inertia` times `mass` if
  /// that is 1.)
  Real inertia_of(Real mass, Real mobile) const { return inertia * mass + (inertia - Real{1}) * (mobile - mass); }
  Real inertia{}, stiffness{}, axial{};
};

/// The preconditioner 1 / D of every cell. D is the diagonal of A with k I for every spring and with 18 springs on every
/// particle. So it is the same for all particles of one material, and rigid motion stays exact. It keeps floats from
/// overflowing and evens out the differences between regions. It is 0 for particles that do not move by their forces.
template <class Real>
void fill_inverse_diagonal(const MethodCells<Real>& cells, const SystemConstants<Real>& system, double q,
                           std::vector<Real>& scale) {
  const CellArrays<Real> arrays = general_arrays(cells);
  const ToolTerms<Real> tools(cells, {}, q);
  for (std::ptrdiff_t i = 0; i < cells.count(); ++i) {
    Real sum = 0;
    for (const std::ptrdiff_t o : arrays.offset) {
      const Real other = arrays.active[i + o] > 0 ? arrays.stiffness[i + o] : arrays.stiffness[i];
      sum += spring_stiffness(arrays.stiffness[i], other) + system.axial;
    }
    for (std::size_t tool = 0; tool < kMaxTools; ++tool)
      sum += arrays.held[tool][i] * (tools.stiffness[tool] + tools.damping[tool]);
    const Real diagonal = system.inertia_of(arrays.mass[i], arrays.mobile[i]) + system.stiffness * sum;
    scale[static_cast<std::size_t>(i)] = arrays.mobile[i] > 0 ? Real{1} / diagonal : Real{0};
  }
}

/// The r' D^-1 r below which conjugate gradients gain nothing more: rounding relative to its first value, plus the number
/// below which squares underflow.
template <class Real>
Real residual_floor(Real first) {
  constexpr Real kRounding = std::numeric_limits<Real>::epsilon();
  return first * kRounding * kRounding + Real{FLT_MIN};
}

}  // namespace evenstep::internal
