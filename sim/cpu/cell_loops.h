#pragma once
/// The kernels of opencl/kernels/*.cl as loops over cells, operation by operation and in the same order. Plain arrays, one
/// per component, every neighbour at a fixed offset and no branch, so that the compiler vectorises them as PoCL does.

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>

#include "src/tissue_solver.h"

// One clone per instruction set, chosen when the program is loaded. The bits are the same: + - * / and sqrt are IEEE-exact
// at every vector width, and nothing is contracted. Sanitizers start only after that choice, so they get one version.
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
/// One array per component; index 0 is the lattice's first cell, ghosts lie before and after.
template <class Real>
struct Vectors {
  Real* __restrict x;
  Real* __restrict y;
  Real* __restrict z;
};

/// Vector from cell i to its neighbour s: (u_j - u_i) + r keeps the digits that positions far from the origin would lose.
template <class Real>
EVENSTEP_INLINE Vector<Real> to_neighbour(const Vectors<const Real>& u, const TissueConstants<Real>& constants,
                                          std::ptrdiff_t i, std::ptrdiff_t j, int s) {
  const auto& rest_m = constants.rest_m[static_cast<std::size_t>(s)];
  return {(u.x[j] - u.x[i]) + rest_m[0], (u.y[j] - u.y[i]) + rest_m[1], (u.z[j] - u.z[i]) + rest_m[2]};
}

/// Sum over the 18 springs of (1 - L / len) d: the force over k. A spring of no length has no direction and so no force: the
/// smallest normal float under the root changes no bit of any other.
template <class Real>
EVENSTEP_INLINE Vector<Real> spring_force(const Vectors<const Real>& u, const Real* __restrict active, const Offsets& offset,
                                          const TissueConstants<Real>& constants, std::ptrdiff_t i) {
  Vector<Real> f;
#pragma GCC unroll 18
  for (int s = 0; s < kNeighbours; ++s) {
    const std::ptrdiff_t j = i + offset[static_cast<std::size_t>(s)];
    const Vector<Real> d = to_neighbour(u, constants, i, j, s);
    const Real length = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN});
    const Real factor = active[j] * (Real{1} - constants.length_m[static_cast<std::size_t>(s)] / length);
    f.x += factor * d.x;
    f.y += factor * d.y;
    f.z += factor * d.z;
  }
  return f;
}

/// advance.cl
template <class Real>
EVENSTEP_WIDE void advance(std::ptrdiff_t count, const Vectors<const Real> u, const Vectors<Real> next,
                           const Vectors<Real> v, const Real* __restrict active, const Real* __restrict mobile,
                           const Offsets& offset, const TissueConstants<Real>& constants) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Vector<Real> f = spring_force(u, active, offset, constants, i);
    const Real acceleration = constants.acceleration * mobile[i], h = constants.step_s * mobile[i];
    v.x[i] = v.x[i] * constants.decay + f.x * acceleration;
    v.y[i] = v.y[i] * constants.decay + f.y * acceleration;
    v.z[i] = v.z[i] * constants.decay + f.z * acceleration;
    next.x[i] = u.x[i] + v.x[i] * h;
    next.y[i] = u.y[i] + v.y[i] * h;
    next.z[i] = u.z[i] + v.z[i] * h;
  }
}

/// energy.cl: kinetic energy of a mobile particle, and half of each of its springs' energy k (len - L)^2 / 2.
template <class Real>
EVENSTEP_WIDE void cell_energy(std::ptrdiff_t count, const Vectors<const Real> u, const Vectors<const Real> v,
                               const Real* __restrict active, const Real* __restrict mobile, const Offsets& offset,
                               const TissueConstants<Real>& constants, Real* __restrict energies) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    Real springs = 0;
#pragma GCC unroll 18
    for (int s = 0; s < kNeighbours; ++s) {
      const std::ptrdiff_t j = i + offset[static_cast<std::size_t>(s)];
      const Vector<Real> d = to_neighbour(u, constants, i, j, s);
      const Real stretch = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z) - constants.length_m[static_cast<std::size_t>(s)];
      springs += active[j] * (stretch * stretch);
    }
    const Real speed2 = v.x[i] * v.x[i] + v.y[i] * v.y[i] + v.z[i] * v.z[i];
    energies[i] = constants.half_mass_kg * mobile[i] * speed2 + constants.quarter_stiffness_N_per_m * active[i] * springs;
  }
}

/// digest.cl. Every NaN counts as the same one: which of its payloads an operation returns is up to the processor.
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
