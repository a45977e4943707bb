#pragma once
/// The kernels of opencl/kernels/*.cl as loops over cells, with the same operations in the same order. They use plain
/// arrays, one per component, with every neighbour at a fixed offset and without branches, so that the compiler vectorises
/// them as PoCL does.

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>

#include "src/tissue/tissue_solver.h"

// One clone per instruction set, chosen when the program is loaded. All clones give the same bits: + - * / and sqrt are
// exact by IEEE 754 at every vector width, and nothing is contracted. Sanitizers start only after the clone is chosen, so
// sanitized builds get a single version.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define EVENSTEP_WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define EVENSTEP_WIDE
#endif
#define EVENSTEP_INLINE [[gnu::always_inline]] inline

namespace evenstep::internal {

using Offsets = std::array<std::ptrdiff_t, kNeighbours>;

template <class Real>
struct Vector {
  Real x{0}, y{0}, z{0};
};
/// One array per component. Index 0 is the lattice's first cell; there are ghost cells before and after.
template <class Real>
struct Vectors {
  Real* x = nullptr;
  Real* y = nullptr;
  Real* z = nullptr;
};

/// The data of every cell that the loops read. Each array starts at the lattice's first cell; an array that the scene does
/// not need is null. Without regions the inverse mass is `mobile`.
template <class Real>
struct CellArrays {
  const Real* active = nullptr;  ///< 1 or 0
  const Real* mobile = nullptr;  ///< 1 or 0
  const Real* stiffness = nullptr;
  const Real* inverse_mass = nullptr;
  const Real* mass = nullptr;
  std::array<const Real*, kMaxTools> held{};  ///< 1 or 0
  Vectors<const Real> rest_m{};               ///< position
  Offsets offset{};
};

/// What a spring force depends on besides its length.
struct SpringFeatures {
  bool regions = false, axial_damping = false;
};

/// The vector from cell i to its neighbour s. Computed as (u_j - u_i) + r, it keeps digits that the difference of two
/// positions far from the origin would lose.
template <class Real>
EVENSTEP_INLINE Vector<Real> to_neighbour(const Vectors<const Real>& u, const TissueConstants<Real>& constants,
                                          std::ptrdiff_t i, std::ptrdiff_t j, int s) {
  const auto& rest_m = constants.rest_m[static_cast<std::size_t>(s)];
  return {(u.x[j] - u.x[i]) + rest_m[0], (u.y[j] - u.y[i]) + rest_m[1], (u.z[j] - u.z[i]) + rest_m[2]};
}

/// The sum over the 18 springs of ((k_i + k_j)/2 (1 - L / len) + c ((v_j - v_i) . n) / len) d, which is the force divided by
/// the scene's k. A spring of length 0 has no direction and so no force. For that the smallest normal float is added under
/// the root; it does not change a bit of any other spring.
template <SpringFeatures kHas, class Real>
EVENSTEP_INLINE Vector<Real> spring_force(const Vectors<const Real>& u, const Vectors<const Real>& v,
                                          const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                                          std::ptrdiff_t i) {
  Vector<Real> f;
#pragma GCC unroll 18
  for (int s = 0; s < kNeighbours; ++s) {
    const auto n = static_cast<std::size_t>(s);
    const std::ptrdiff_t j = i + cells.offset[n];
    const Vector<Real> d = to_neighbour(u, constants, i, j, s);
    const Real part = constants.length_m[n] / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN});
    Real factor = Real{1} - part;
    if constexpr (kHas.regions) factor = spring_stiffness(cells.stiffness[i], cells.stiffness[j]) * factor;
    if constexpr (kHas.axial_damping) {
      const Real along = (v.x[j] - v.x[i]) * d.x + (v.y[j] - v.y[i]) * d.y + (v.z[j] - v.z[i]) * d.z;
      factor = factor + constants.axial_s_per_m2[n] * (along * part) * part;
    }
    factor = cells.active[j] * factor;
    f.x += factor * d.x;
    f.y += factor * d.y;
    f.z += factor * d.z;
  }
  return f;
}

/// spring_force with the features chosen at run time, for a few cells.
template <class Real>
Vector<Real> spring_force(const SpringFeatures& has, const Vectors<const Real>& u, const Vectors<const Real>& v,
                          const CellArrays<Real>& cells, const TissueConstants<Real>& constants, std::ptrdiff_t i) {
  if (has.regions && has.axial_damping) return spring_force<SpringFeatures{true, true}>(u, v, cells, constants, i);
  if (has.regions) return spring_force<SpringFeatures{true, false}>(u, v, cells, constants, i);
  if (has.axial_damping) return spring_force<SpringFeatures{false, true}>(u, v, cells, constants, i);
  return spring_force<SpringFeatures{false, false}>(u, v, cells, constants, i);
}

/// The state of a tool as the kernels get it.
template <class Real>
struct ToolVectors {
  explicit ToolVectors(const ToolState& state)
      : offset_m{static_cast<Real>(state.offset_m[0]), static_cast<Real>(state.offset_m[1]),
                 static_cast<Real>(state.offset_m[2])},
        velocity_m_per_s{static_cast<Real>(state.velocity_m_per_s[0]), static_cast<Real>(state.velocity_m_per_s[1]),
                         static_cast<Real>(state.velocity_m_per_s[2])} {}
  Vector<Real> offset_m, velocity_m_per_s;
};

/// The force of a virtual coupling, k (x_tool - u) + b (v_tool - v), divided by the scene's k.
template <class Real>
EVENSTEP_INLINE Vector<Real> coupling_force(const Vectors<const Real>& u, const Vectors<const Real>& v,
                                            const ToolConstants<Real>& constants, const ToolVectors<Real>& tool,
                                            std::ptrdiff_t i) {
  const auto& [x, w] = tool;
  return {constants.stiffness * (x.x - u.x[i]) + constants.damping_s * (w.x - v.x[i]),
          constants.stiffness * (x.y - u.y[i]) + constants.damping_s * (w.y - v.y[i]),
          constants.stiffness * (x.z - u.z[i]) + constants.damping_s * (w.z - v.z[i])};
}

/// The macro INSIDE of the kernels: the depth, or 0 outside.
template <class Real>
EVENSTEP_INLINE Real inside_of(Real depth) {
  return (depth + std::abs(depth)) * Real{0.5};
}

/// The vector from a probe's centre to a particle.
template <class Real>
EVENSTEP_INLINE Vector<Real> from_probe(const Vectors<const Real>& u, const Vectors<const Real>& rest_m,
                                        const ToolConstants<Real>& constants, const Vector<Real>& offset_m,
                                        std::ptrdiff_t i) {
  return {(u.x[i] - offset_m.x) + (rest_m.x[i] - constants.center_m[0]),
          (u.y[i] - offset_m.y) + (rest_m.y[i] - constants.center_m[1]),
          (u.z[i] - offset_m.z) + (rest_m.z[i] - constants.center_m[2])};
}

/// The forces on the cells of one chunk, divided by the scene's k.
template <class Real>
struct ChunkForces {
  alignas(64) Real x[kChunk], y[kChunk], z[kChunk];
};

template <SpringFeatures kHas, class Real>
EVENSTEP_WIDE void chunk_spring_forces(std::ptrdiff_t begin, const Vectors<const Real> u, const Vectors<const Real> v,
                                       const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                                       ChunkForces<Real>& __restrict forces) {
  for (std::ptrdiff_t n = 0; n < static_cast<std::ptrdiff_t>(kChunk); ++n) {
    const Vector<Real> f = spring_force<kHas>(u, v, cells, constants, begin + n);
    forces.x[n] = f.x;
    forces.y[n] = f.y;
    forces.z[n] = f.z;
  }
}

template <class Real>
EVENSTEP_WIDE void add_coupling(std::ptrdiff_t begin, const Vectors<const Real> u, const Vectors<const Real> v,
                                const Real* __restrict held, const ToolConstants<Real>& constants,
                                const ToolVectors<Real>& tool, ChunkForces<Real>& __restrict forces) {
  for (std::ptrdiff_t n = 0; n < static_cast<std::ptrdiff_t>(kChunk); ++n) {
    const Vector<Real> f = coupling_force(u, v, constants, tool, begin + n);
    forces.x[n] += held[begin + n] * f.x;
    forces.y[n] += held[begin + n] * f.y;
    forces.z[n] += held[begin + n] * f.z;
  }
}

template <class Real>
EVENSTEP_WIDE void add_probe(std::ptrdiff_t begin, const Vectors<const Real> u, const Vectors<const Real> rest_m,
                             const ToolConstants<Real>& constants, const ToolVectors<Real>& tool,
                             ChunkForces<Real>& __restrict forces) {
  for (std::ptrdiff_t n = 0; n < static_cast<std::ptrdiff_t>(kChunk); ++n) {
    const Vector<Real> d = from_probe(u, rest_m, constants, tool.offset_m, begin + n);
    const Real distance = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN});
    const Real depth = constants.radius_m - distance;
    const Real factor = constants.stiffness * inside_of(depth) / distance;
    forces.x[n] += factor * d.x;
    forces.y[n] += factor * d.y;
    forces.z[n] += factor * d.z;
  }
}

/// All forces of springs and tools on a chunk of cells, divided by the scene's k. Gravity and drag are added later, as
/// accelerations.
template <class Real>
void chunk_forces(const SceneFeatures& features, std::ptrdiff_t begin, const Vectors<const Real>& u,
                  const Vectors<const Real>& v, const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                  const ToolStates& tools, ChunkForces<Real>& forces) {
  if (features.regions && features.axial_damping)
    chunk_spring_forces<SpringFeatures{true, true}>(begin, u, v, cells, constants, forces);
  else if (features.regions)
    chunk_spring_forces<SpringFeatures{true, false}>(begin, u, v, cells, constants, forces);
  else if (features.axial_damping)
    chunk_spring_forces<SpringFeatures{false, true}>(begin, u, v, cells, constants, forces);
  else
    chunk_spring_forces<SpringFeatures{false, false}>(begin, u, v, cells, constants, forces);
  for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
    const ToolVectors<Real> at(tools[tool]);
    if (features.spring[tool]) add_coupling<Real>(begin, u, v, cells.held[tool], constants.tools[tool], at, forces);
  }
  for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
    const ToolVectors<Real> at(tools[tool]);
    if (features.probe[tool]) add_probe<Real>(begin, u, cells.rest_m, constants.tools[tool], at, forces);
  }
}

/// What changes a velocity besides springs and tools.
struct BodyFeatures {
  bool damping = false, gravity = false;
};

/// advance.cl, after the forces are known. `before` and `v` may be the same array.
template <BodyFeatures kHas, class Real>
EVENSTEP_WIDE void advance_chunk(std::ptrdiff_t begin, const ChunkForces<Real>& __restrict forces,
                                 const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                                 const Vectors<const Real> u, const Vectors<Real> next, const Vectors<const Real> before,
                                 const Vectors<Real> v) {
  const Real* const inverse_mass = cells.inverse_mass;
  const Real* const is_mobile = cells.mobile;
  const Real per_mass = constants.acceleration, step_s = constants.step_s, decay = constants.decay;
  const auto [gx, gy, gz] = constants.gravity;
#pragma GCC ivdep
  for (std::ptrdiff_t n = 0; n < static_cast<std::ptrdiff_t>(kChunk); ++n) {
    const std::ptrdiff_t i = begin + n;
    const Real acceleration = per_mass * inverse_mass[i], mobile = is_mobile[i], h = step_s * mobile;
    Vector<Real> w{before.x[i], before.y[i], before.z[i]};
    if constexpr (kHas.damping) {
      const Real d = decay + (Real{1} - decay) * (mobile - inverse_mass[i]);  // the same drag on a particle of another mass
      w = {w.x * d, w.y * d, w.z * d};
    }
    w = {w.x + forces.x[n] * acceleration, w.y + forces.y[n] * acceleration, w.z + forces.z[n] * acceleration};
    if constexpr (kHas.gravity) w = {w.x + gx * mobile, w.y + gy * mobile, w.z + gz * mobile};
    v.x[i] = w.x;
    v.y[i] = w.y;
    v.z[i] = w.z;
    next.x[i] = u.x[i] + w.x * h;
    next.y[i] = u.y[i] + w.y * h;
    next.z[i] = u.z[i] + w.z * h;
  }
}

/// verlet.cl: the velocity after half a step, then the displacement.
template <class Real>
EVENSTEP_WIDE void drift(std::ptrdiff_t count, const Real* __restrict mobile, const TissueConstants<Real>& constants,
                         const Real* __restrict v, const Real* __restrict a, Real* __restrict half, Real* __restrict u) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    half[i] = v[i] + a[i] * constants.half_step_s;
    u[i] = u[i] + half[i] * (constants.step_s * mobile[i]);
  }
}

/// verlet.cl, after the forces with the half step's velocity: the acceleration, and the velocity at the end of the substep.
template <BodyFeatures kHas, class Real>
EVENSTEP_WIDE void accelerate_chunk(std::ptrdiff_t begin, const ChunkForces<Real>& __restrict forces,
                                    const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                                    const Vectors<const Real> half, const Vectors<Real> v, const Vectors<Real> a) {
#pragma GCC ivdep
  for (std::ptrdiff_t n = 0; n < static_cast<std::ptrdiff_t>(kChunk); ++n) {
    const std::ptrdiff_t i = begin + n;
    const Real per_kg = constants.stiffness_per_kg * cells.inverse_mass[i], mobile = cells.mobile[i];
    Vector<Real> b{forces.x[n] * per_kg, forces.y[n] * per_kg, forces.z[n] * per_kg};
    if constexpr (kHas.damping) {
      const Real d = constants.damping_per_s * cells.inverse_mass[i];
      b = {b.x - half.x[i] * d, b.y - half.y[i] * d, b.z - half.z[i] * d};
    }
    if constexpr (kHas.gravity) {
      const auto& g = constants.gravity_m_per_s2;
      b = {b.x + g[0] * mobile, b.y + g[1] * mobile, b.z + g[2] * mobile};
    }
    a.x[i] = b.x;
    a.y[i] = b.y;
    a.z[i] = b.z;
    v.x[i] = half.x[i] + b.x * constants.half_step_s;
    v.y[i] = half.y[i] + b.y * constants.half_step_s;
    v.z[i] = half.z[i] + b.z * constants.half_step_s;
  }
}

/// energy.cl: kinetic energy of a mobile particle, and half of each of its springs' energy k (len - L)^2 / 2. `mass` is
/// `mobile` without regions.
template <bool kRegions, class Real>
EVENSTEP_WIDE void cell_energy(std::ptrdiff_t count, const Vectors<const Real> u, const Vectors<const Real> v,
                               const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                               Real* __restrict energies) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    Real springs = 0;
#pragma GCC unroll 18
    for (int s = 0; s < kNeighbours; ++s) {
      const std::ptrdiff_t j = i + cells.offset[static_cast<std::size_t>(s)];
      const Vector<Real> d = to_neighbour(u, constants, i, j, s);
      const Real stretch = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) - constants.length_m[static_cast<std::size_t>(s)];
      Real square = stretch * stretch;
      if constexpr (kRegions) square = spring_stiffness(cells.stiffness[i], cells.stiffness[j]) * square;
      springs += cells.active[j] * square;
    }
    const Real speed2 = v.x[i] * v.x[i] + v.y[i] * v.y[i] + v.z[i] * v.z[i];
    energies[i] =
        constants.half_mass_kg * cells.mass[i] * speed2 + constants.quarter_stiffness_N_per_m * cells.active[i] * springs;
  }
}

template <class Real>
EVENSTEP_WIDE void add_coupling_energy(std::ptrdiff_t count, const Vectors<const Real> u, const Real* __restrict held,
                                       const ToolConstants<Real>& constants, const ToolVectors<Real>& tool,
                                       Real* __restrict energies) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Vector<Real> d{tool.offset_m.x - u.x[i], tool.offset_m.y - u.y[i], tool.offset_m.z - u.z[i]};
    energies[i] += constants.half_stiffness_N_per_m * held[i] * (d.x * d.x + d.y * d.y + d.z * d.z);
  }
}

template <class Real>
EVENSTEP_WIDE void add_probe_energy(std::ptrdiff_t count, const Vectors<const Real> u, const CellArrays<Real>& cells,
                                    const ToolConstants<Real>& constants, const ToolVectors<Real>& tool,
                                    Real* __restrict energies) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Vector<Real> d = from_probe(u, cells.rest_m, constants, tool.offset_m, i);
    const Real depth = constants.radius_m - std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN});
    const Real inside = inside_of(depth);
    energies[i] += constants.half_stiffness_N_per_m * cells.mobile[i] * (inside * inside);
  }
}

/// The potential energy of a mobile particle's weight, 0 at rest.
template <class Real>
EVENSTEP_WIDE void gravity_energy(std::ptrdiff_t count, const Vectors<const Real> u, const CellArrays<Real>& cells,
                                  const TissueConstants<Real>& constants, Real* __restrict energies) {
  const auto& [x, y, z] = constants.weight_N;
  for (std::ptrdiff_t i = 0; i < count; ++i) energies[i] = -(cells.mass[i] * (x * u.x[i] + y * u.y[i] + z * u.z[i]));
}

/// probe.cl: partial sums for ProbeSums as sums[value * partials + partial], each over kChunk cells that are `partials`
/// apart.
template <bool kLocalModel, class Real>
EVENSTEP_WIDE void probe_sums(std::ptrdiff_t partials, const Vectors<const Real> u, const CellArrays<Real>& cells,
                              const ToolConstants<Real>& constants, const ToolVectors<Real>& tool, Real* __restrict sums) {
  for (std::ptrdiff_t part = 0; part < partials; ++part) {
    for (std::size_t value = 0; value < (kLocalModel ? kProbeValues : kProbeForces); ++value)
      sums[static_cast<std::ptrdiff_t>(value) * partials + part] = value + 1 == kProbeValues ? Real{FLT_MAX} : Real{0};
  }
  for (std::ptrdiff_t chunk = 0; chunk < static_cast<std::ptrdiff_t>(kChunk); ++chunk) {
#pragma GCC ivdep
    for (std::ptrdiff_t part = 0; part < partials; ++part) {
      const std::ptrdiff_t i = chunk * partials + part;
      const Vector<Real> d = from_probe(u, cells.rest_m, constants, tool.offset_m, i);
      const Real square = d.x * d.x + d.y * d.y + d.z * d.z, distance = std::sqrt(square + Real{FLT_MIN});
      const Real depth = constants.radius_m - distance;
      const Real inside = inside_of(depth);
      const Real factor = cells.mobile[i] * (constants.stiffness * inside / distance);
      Real* const sum = sums + part;
      sum[0] += factor * d.x;
      sum[partials] += factor * d.y;
      sum[2 * partials] += factor * d.z;
      if constexpr (kLocalModel) {
        const Real weight = cells.mobile[i] * inside;
        sum[3 * partials] += weight;
        sum[4 * partials] += weight * (cells.rest_m.x[i] + u.x[i]);
        sum[5 * partials] += weight * (cells.rest_m.y[i] + u.y[i]);
        sum[6 * partials] += weight * (cells.rest_m.z[i] + u.z[i]);
        // k (n n' + (1 - r/|d|) (I - n n')), and 0 at the very centre, where there is no direction.
        const Real stiffness = depth > 0 && square > 0 ? cells.mobile[i] * constants.stiffness : Real{0};
        const Real ratio = constants.radius_m / distance, across = stiffness * (Real{1} - ratio);
        const Real nx = d.x / distance, ny = d.y / distance, nz = d.z / distance, along = stiffness * ratio;
        sum[7 * partials] += along * (nx * nx) + across;
        sum[8 * partials] += along * (ny * ny) + across;
        sum[9 * partials] += along * (nz * nz) + across;
        sum[10 * partials] += along * (nx * ny);
        sum[11 * partials] += along * (nx * nz);
        sum[12 * partials] += along * (ny * nz);
        const Real gap = cells.mobile[i] > 0 ? distance - constants.radius_m : Real{FLT_MAX};
        sum[13 * partials] = gap < sum[13 * partials] ? gap : sum[13 * partials];
      }
    }
  }
}

/// sums.cl. All NaNs count as one and the same, because a NaN's payload depends on the processor.
EVENSTEP_INLINE std::uint64_t bits(float value) {
  return value == value ? std::bit_cast<std::uint32_t>(value) : 0x7fc00000u;
}
EVENSTEP_INLINE std::uint64_t bits(double value) {
  return value == value ? std::bit_cast<std::uint64_t>(value) : 0x7ff8000000000000u;
}

template <class Real>
EVENSTEP_WIDE std::uint64_t chunk_digest(std::ptrdiff_t begin, std::ptrdiff_t end, const Vectors<const Real> u,
                                         const Vectors<const Real> v) {
  std::uint64_t sum = 0;
  for (std::ptrdiff_t i = begin; i < end; ++i) {
    std::uint64_t h = static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15u;
    h += bits(u.x[i]) * 0xff51afd7ed558ccdu;
    h += bits(u.y[i]) * 0xc4ceb9fe1a85ec53u;
    h += bits(u.z[i]) * 0xbf58476d1ce4e5b9u;
    h += bits(v.x[i]) * 0x94d049bb133111ebu;
    h += bits(v.y[i]) * 0xd6e8feb86659fd93u;
    h += bits(v.z[i]) * 0xa0761d6478bd642fu;
    h ^= h >> 32;
    h *= 0xe7037ed1a0b428dbu;
    sum += h ^ (h >> 29);
  }
  return sum;
}

}  // namespace evenstep::internal
