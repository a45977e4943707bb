#pragma once
/// The accelerations of all cells for any state: what every method but the explicit one-loop ones asks for.

#include "cpu/method.h"

namespace evenstep::internal {

template <class Real>
EVENSTEP_WIDE void cell_accelerations(std::ptrdiff_t count, const Vectors<const Real> u, const Vectors<const Real> v,
                                      const Real* __restrict active, const Real* __restrict mobile, const Offsets& offset,
                                      const TissueConstants<Real>& constants, Real stiffness_per_kg, Real damping_per_s,
                                      const Vectors<Real> a) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Vector<Real> f = spring_force(u, active, offset, constants, i);
    a.x[i] = mobile[i] * (f.x * stiffness_per_kg - v.x[i] * damping_per_s);
    a.y[i] = mobile[i] * (f.y * stiffness_per_kg - v.y[i] * damping_per_s);
    a.z[i] = mobile[i] * (f.z * stiffness_per_kg - v.z[i] * damping_per_s);
  }
}

/// a(u, v), zero for particles that do not move by their forces.
template <class Real>
void accelerations(const MethodCells<Real>& cells, const Vectors<const Real>& u, const Vectors<const Real>& v,
                   const Vectors<Real>& a) {
  const TissueScene& scene = cells.scene;
  cell_accelerations<Real>(cells.count(), u, v, cells.active, cells.mobile, cells.lattice.offset, cells.constants,
                           static_cast<Real>(scene.stiffness_N_per_m / scene.particle_mass_kg),
                           static_cast<Real>(scene.damping_per_s), a);
}

/// A grabbed particle has one velocity in the whole substep, the one that brings it from where it is to its target.
template <class Real>
void start_grabs(const MethodCells<Real>& cells, std::span<const GrabTarget> targets, double substep_s,
                 const Vectors<Real>& u, const Vectors<Real>& v) {
  for (std::size_t tool = 0; tool < targets.size(); ++tool) {
    if (cells.scene.tools[tool].kind != CouplingKind::grab) continue;
    const auto& to_m = targets[tool].offset_m;
    for (const std::uint32_t cell : cells.lattice.held[tool]) {
      const std::size_t i = cell - cells.lattice.first;
      v.x[i] = static_cast<Real>((to_m[0] - u.x[i]) / substep_s);
      v.y[i] = static_cast<Real>((to_m[1] - u.y[i]) / substep_s);
      v.z[i] = static_cast<Real>((to_m[2] - u.z[i]) / substep_s);
    }
  }
}

/// At the substep's end: exactly at the target.
template <class Real>
void end_grabs(const MethodCells<Real>& cells, std::span<const GrabTarget> targets, const Vectors<Real>& u,
               const Vectors<Real>& v) {
  for (std::size_t tool = 0; tool < targets.size(); ++tool) {
    if (cells.scene.tools[tool].kind != CouplingKind::grab) continue;
    const auto& [to_m, velocity_m_per_s] = targets[tool];
    for (const std::uint32_t cell : cells.lattice.held[tool]) {
      const std::size_t i = cell - cells.lattice.first;
      u.x[i] = static_cast<Real>(to_m[0]), u.y[i] = static_cast<Real>(to_m[1]), u.z[i] = static_cast<Real>(to_m[2]);
      v.x[i] = static_cast<Real>(velocity_m_per_s[0]);
      v.y[i] = static_cast<Real>(velocity_m_per_s[1]);
      v.z[i] = static_cast<Real>(velocity_m_per_s[2]);
    }
  }
}

}  // namespace evenstep::internal
