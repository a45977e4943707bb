#pragma once
/// What the methods in methods/ have in common: the accelerations of all cells for any state, and grabbed particles.

#include "cpu/method.h"

namespace evenstep::internal {

template <class Real>
EVENSTEP_WIDE void chunk_accelerations(std::ptrdiff_t begin, const ChunkForces<Real>& __restrict forces,
                                       const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                                       const Vectors<const Real> v, const Vectors<Real> a) {
  const auto [gx, gy, gz] = constants.gravity_m_per_s2;
#pragma GCC ivdep
  for (std::ptrdiff_t n = 0; n < static_cast<std::ptrdiff_t>(kChunk); ++n) {
    const std::ptrdiff_t i = begin + n;
    const Real per_kg = constants.stiffness_per_kg * cells.inverse_mass[i], mobile = cells.mobile[i];
    const Real drag = constants.damping_per_s * cells.inverse_mass[i];
    a.x[i] = forces.x[n] * per_kg + (mobile * gx - drag * v.x[i]);
    a.y[i] = forces.y[n] * per_kg + (mobile * gy - drag * v.y[i]);
    a.z[i] = forces.z[n] * per_kg + (mobile * gz - drag * v.z[i]);
  }
}

/// a(u, v) with the tools at `tools`; zero for particles that do not move by their forces.
template <class Real>
void accelerations(const MethodCells<Real>& cells, const Vectors<const Real>& u, const Vectors<const Real>& v,
                   const ToolStates& tools, const Vectors<Real>& a) {
  ChunkForces<Real> forces;
  for (std::ptrdiff_t begin = 0; begin < cells.count(); begin += static_cast<std::ptrdiff_t>(kChunk)) {
    chunk_forces<Real>(cells.features, begin, u, v, cells.arrays, cells.constants, tools, forces);
    chunk_accelerations<Real>(begin, forces, cells.arrays, cells.constants, v, a);
  }
}

/// The tools after a part (0 to 1) of the substep, during which they move in a straight line.
inline ToolStates tools_after(double part, const ToolStates& before, const ToolStates& after) {
  ToolStates between = after;
  for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double from_m = before[tool].offset_m[axis];
      between[tool].offset_m[axis] = from_m + (after[tool].offset_m[axis] - from_m) * part;
    }
  }
  return between;
}

/// Calls `put` for each grabbed cell, with its index counted from the lattice's first cell and the state of its tool.
template <class Real, class Put>
void for_grabs(const MethodCells<Real>& cells, const ToolStates& tools, const Put& put) {
  for (std::size_t tool = 0; tool < cells.lattice.held.size(); ++tool) {
    if (!cells.features.grab[tool]) continue;
    for (const std::uint32_t cell : cells.lattice.held[tool]) put(cell - cells.lattice.first, tools[tool]);
  }
}

/// During the whole substep a grabbed particle has one velocity: the one that takes it from where it is to its tool.
template <class Real>
void start_grabs(const MethodCells<Real>& cells, const ToolStates& after, double substep_s, const Vectors<Real>& u,
                 const Vectors<Real>& v) {
  const auto h = static_cast<Real>(substep_s);
  for_grabs(cells, after, [&](std::size_t i, const ToolState& tool) {
    v.x[i] = (static_cast<Real>(tool.offset_m[0]) - u.x[i]) / h;
    v.y[i] = (static_cast<Real>(tool.offset_m[1]) - u.y[i]) / h;
    v.z[i] = (static_cast<Real>(tool.offset_m[2]) - u.z[i]) / h;
  });
}

/// At the end of the substep: puts the grabbed particles exactly where their tool is.
template <class Real>
void end_grabs(const MethodCells<Real>& cells, const ToolStates& after, const Vectors<Real>& u, const Vectors<Real>& v) {
  for_grabs(cells, after, [&](std::size_t i, const ToolState& tool) {
    const auto& [at_m, velocity_m_per_s] = tool;
    u.x[i] = static_cast<Real>(at_m[0]), v.x[i] = static_cast<Real>(velocity_m_per_s[0]);
    u.y[i] = static_cast<Real>(at_m[1]), v.y[i] = static_cast<Real>(velocity_m_per_s[1]);
    u.z[i] = static_cast<Real>(at_m[2]), v.z[i] = static_cast<Real>(velocity_m_per_s[2]);
  });
}

/// The cells' arrays for the general version of the loops. An array that the scene does not need gets neutral values
/// (stiffness 1), or any values if the constants that they are multiplied by are zero.
template <class Real>
CellArrays<Real> general_arrays(const MethodCells<Real>& cells) {
  CellArrays<Real> arrays = cells.arrays;
  if (!arrays.stiffness) arrays.stiffness = arrays.active;
  for (const Real*& held : arrays.held)
    if (!held) held = arrays.active;
  if (!arrays.rest_m.x) arrays.rest_m = {arrays.active, arrays.active, arrays.active};
  return arrays;
}

/// The tools of a scene at the end of a time q: their positions, and a coupling's k and b / q divided by the scene's
/// stiffness.
template <class Real>
struct ToolTerms {
  ToolTerms(const MethodCells<Real>& cells, const ToolStates& tools, double q_s)
      : at{ToolVectors<Real>(tools[0]), ToolVectors<Real>(tools[1])} {
    for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
      if (!cells.features.spring[tool]) continue;
      stiffness[tool] = cells.constants.tools[tool].stiffness;
      damping[tool] = cells.constants.tools[tool].damping_s / static_cast<Real>(q_s);
    }
  }
  std::array<ToolVectors<Real>, kMaxTools> at;
  std::array<Real, kMaxTools> stiffness{}, damping{};
};

/// A probe's force on a particle is factor d. Its stiffness matrix is stiffness d d'; the negative part, by which the push
/// turns with the particle, is left out.
template <class Real>
struct ProbeTerm {
  Vector<Real> d;
  Real factor, stiffness;
};
template <class Real>
EVENSTEP_INLINE ProbeTerm<Real> probe_term(const Vectors<const Real>& u, const CellArrays<Real>& cells,
                                           const ToolConstants<Real>& constants, const ToolVectors<Real>& tool,
                                           std::ptrdiff_t i) {
  const Vector<Real> d = from_probe(u, cells.rest_m, constants, tool.offset_m, i);
  const Real distance = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN});
  const Real depth = constants.radius_m - distance, inverse = Real{1} / distance;
  const Real stiffness = depth > 0 ? constants.stiffness : Real{0};
  return {d, stiffness * depth * inverse, stiffness * inverse * inverse};
}

}  // namespace evenstep::internal
