#include "cases/linear_map.h"

#include <cassert>
#include <cmath>

namespace evenstep::internal {
namespace {

using Real = LinearMap::Real;

/// A mode that grows or falls without turning: eigenvalues l1, l2 of M, M^n = (l1^n (M - l2) - l2^n (M - l1)) / (l1 - l2).
LinearMap::State real_power(const LinearMap& m, Real n, LinearMap::State z) {
  const Real mean = (m.a + m.d) / 2, half = std::sqrt((m.a - m.d) * (m.a - m.d) / 4 + m.b * m.c);
  // The larger one first, the other by the determinant: no cancellation.
  const Real first = mean < 0 ? mean - half : mean + half, second = m.determinant / first;
  const LinearMap::State mz = m.times(z);
  const Real p1 = std::pow(first, n), p2 = std::pow(second, n), gap = first - second;
  return {(p1 * (mz.x - second * z.x) - p2 * (mz.x - first * z.x)) / gap,
          (p1 * (mz.v - second * z.v) - p2 * (mz.v - first * z.v)) / gap};
}

}  // namespace

Real LinearMap::angle() const { return std::atan2(std::sqrt(-b * c - (a - d) * (a - d) / 4), (a + d) / 2); }

LinearMap::State LinearMap::power(Real n, State z) const {
  if (!oscillates()) return real_power(*this, n, z);
  const Real theta = angle(), r = std::sqrt(determinant);
  const Real scale = std::pow(r, n), turned = std::sin(n * theta) / std::sin(theta), kept = std::cos(n * theta);
  const Real rest = kept - turned * std::cos(theta);
  const State mz = times(z);
  return {scale * (rest * z.x + turned * mz.x / r), scale * (rest * z.v + turned * mz.v / r)};
}

Real LinearMap::amplitude(State z) const { return std::sqrt(invariant(z) * b / (-b * c - (a - d) * (a - d) / 4)); }

LinearMap linear_map(Method method, Real w2, Real damping, Real h) {
  const Real z2 = w2 * h * h, g = damping * h;
  switch (method) {
    case Method::symplectic_euler:
      return {1 - z2, h * (1 - g), -h * w2, 1 - g, 1 - g};
    case Method::velocity_verlet:
      assert(damping == 0);
      return {1 - z2 / 2, h, -h * w2 * (1 - z2 / 4), 1 - z2 / 2, 1};
    case Method::rk4: {
      // Powers of h A = [0 h; -h w^2 -g] on the two unit vectors.
      LinearMap map{1, 0, 0, 1};
      Real pa = 1, pb = 0, pc = 0, pd = 1, factor = 1;
      for (int j = 1; j <= 4; ++j) {
        const Real na = h * pc, nb = h * pd, nc = -h * w2 * pa - g * pc, nd = -h * w2 * pb - g * pd;
        pa = na, pb = nb, pc = nc, pd = nd;
        factor /= j;
        map.a += factor * pa, map.b += factor * pb, map.c += factor * pc, map.d += factor * pd;
      }
      map.determinant = damping == 0 ? 1 - z2 * z2 * z2 / 72 + z2 * z2 * z2 * z2 / 576 : map.a * map.d - map.b * map.c;
      return map;
    }
    case Method::implicit_euler:
    case Method::vertex_block_descent: {
      const Real det = 1 / (1 + g + z2);
      return {(1 + g) * det, h * det, -h * w2 * det, det, det};
    }
    case Method::implicit_midpoint: {
      const Real det = 1 / (1 + g / 2 + z2 / 4);
      return {(1 + g / 2 - z2 / 4) * det, h * det, -h * w2 * det, (1 - g / 2 - z2 / 4) * det, (1 - g / 2 + z2 / 4) * det};
    }
  }
  return {};
}

LinearMap exact_map(Real w2, Real damping, Real h) {
  const Real decay = std::exp(-damping * h / 2), discriminant = w2 - damping * damping / 4;
  Real s = h, c = 1;  // sin(q h) / q and cos(q h), q^2 = discriminant
  if (discriminant > 0) {
    const Real q = std::sqrt(discriminant);
    s = std::sin(q * h) / q, c = std::cos(q * h);
  } else if (discriminant < 0) {
    const Real q = std::sqrt(-discriminant);
    s = std::sinh(q * h) / q, c = std::cosh(q * h);
  }
  return {decay * (c + damping / 2 * s), decay * s, -decay * w2 * s, decay * (c - damping / 2 * s), decay * decay};
}

}  // namespace evenstep::internal
