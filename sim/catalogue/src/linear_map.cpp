#include "evenstep/catalogue/linear_map.h"

#include <cassert>
#include <cmath>

namespace evenstep::internal {
namespace {

using Real = LinearMap::Real;

/// The constants that the classical method multiplies with: h / 6, h / 3, h / 2 and h, rounded or not.
struct RungeKuttaSteps {
  Real sixth, third, half, whole;
};

/// y <- y + sixth k1 + third k2 + third k3 + sixth k4 on the two unit vectors.
LinearMap runge_kutta_map(Real w2, Real damping, const RungeKuttaSteps& h) {
  using State = LinearMap::State;
  const auto slope = [&](State y) { return State{y.v, -w2 * y.x - damping * y.v}; };
  const auto along = [](State y, Real reach, State k) { return State{y.x + reach * k.x, y.v + reach * k.v}; };
  const auto step = [&](State y) {
    const State k1 = slope(y), k2 = slope(along(y, h.half, k1)), k3 = slope(along(y, h.half, k2));
    const State k4 = slope(along(y, h.whole, k3));
    return along(along(along(along(y, h.sixth, k1), h.third, k2), h.third, k3), h.sixth, k4);
  };
  const State x = step({1, 0}), v = step({0, 1});
  return {x.x, v.x, x.v, v.v, x.x * v.v - v.x * x.v};
}

/// A mode that grows or falls without turning: eigenvalues l1, l2 of M, M^n = (l1^n (M - l2) - l2^n (M - l1)) / (l1 - l2).
LinearMap::State real_power(const LinearMap& m, Real n, LinearMap::State z) {
  const Real mean = (m.a + m.d) / 2, half = std::sqrt((m.a - m.d) * (m.a - m.d) / 4 + m.b * m.c);
  // The larger eigenvalue comes first, and the other one from the determinant, which avoids cancellation.
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
      LinearMap map = runge_kutta_map(w2, damping, {h / 6, h / 3, h / 2, h});
      if (damping == 0) map.determinant = 1 - z2 * z2 * z2 / 72 + z2 * z2 * z2 * z2 / 576;
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

LinearMap float_linear_map(Method method, double stiffness_N_per_m, double particle_mass_kg, double h_s) {
  const auto rounded = [](double x) -> Real { return static_cast<float>(x); };
  const Real h = rounded(h_s), w2 = rounded(stiffness_N_per_m / particle_mass_kg);
  const Real z2 = rounded(h_s * h_s * stiffness_N_per_m / particle_mass_kg), det = 1 / (1 + z2);
  switch (method) {
    case Method::symplectic_euler:
      return linear_map(method, rounded(stiffness_N_per_m * h_s / particle_mass_kg) / h, 0, h);
    case Method::velocity_verlet:
    case Method::implicit_midpoint:  // its second Newton step corrects the error of its own z^2 / 4
      return linear_map(method, w2, 0, h);
    case Method::rk4:
      return runge_kutta_map(w2, 0, {rounded(h_s / 6), rounded(h_s / 3), rounded(h_s / 2), h});
    case Method::implicit_euler:  // v' = (v - h w^2 x) / (1 + z^2), x' = x + h v'
      return {1 - h * h * w2 * det, h * det, -h * w2 * det, det, det};
    case Method::vertex_block_descent: {  // x' = (x + h v) / (1 + z^2), v' = (x' - x) / h
      const Real per_h = rounded(1 / h_s);
      return {det, h * det, -per_h * z2 * det, per_h * h * det, per_h * h * det};
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
