#pragma once
/// One step of a method on a mode as a matrix. The mode is (x, v) of a unit mass on a spring w^2 with damping d, the step is
/// h. On a linear system every method is such a 2 x 2 matrix M, and its n-th power is exactly what the method must give
/// after n steps. So tests against it are sharp however coarse the step is.
///
///   symplectic Euler   v' = (1 - h d) v - h w^2 x,  x' = x + h v'                    det M = 1 - h d
///   velocity Verlet    v* = v - h w^2 x / 2,  x' = x + h v*,  v' = v* - h w^2 x' / 2     (d = 0)  det M = 1
///   Runge-Kutta        sum of (h A)^j / j!, j = 0 .. 4, A = [0 1; -w^2 -d]           det M = 1 - z^6/72 + z^8/576 (d = 0)
///   implicit Euler     (I - h A)^-1                                                   det M = 1 / (1 + h d + z^2)
///   implicit midpoint  (I - h A / 2)^-1 (I + h A / 2)                                 det M = 1 (d = 0)
/// with z = w h. With complex eigenvalues r exp(+- i theta), r^2 = det M:
///   M^n = r^n (cos(n theta) I + sin(n theta) / sin(theta) (M / r - cos(theta) I)),
/// and theta is computed from its sine, sqrt(-b c - (a - d)^2 / 4) / r, if w h is so small that its cosine is 1. For
/// symplectic Euler, sin(theta / 2) = w h / 2. The form Q = -c x^2 + (a - d) x v + b v^2 is multiplied by det M in every
/// step; for a symplectic method it is the energy that the method conserves instead of the true one. (Hairer, Lubich,
/// Wanner, Geometric Numerical Integration, 2nd ed., IX.)

#include "evenstep/sim/scene.h"

namespace evenstep::internal {

/// z' = M z, z = (x, v), in long double, whose rounding is 1/2000 of that of the doubles that are judged.
struct LinearMap {
  using Real = long double;
  Real a = 1, b = 0, c = 0, d = 1;  ///< [a b; c d]
  Real determinant = 1;             ///< in closed form, which avoids the cancellation in a d - b c

  struct State {
    Real x = 0, v = 0;
  };
  State times(State z) const { return {a * z.x + b * z.v, c * z.x + d * z.v}; }
  /// Whether the eigenvalues are complex; only then are there an angle, a conserved form and an amplitude.
  bool oscillates() const { return -b * c - (a - d) * (a - d) / 4 > 0; }
  Real angle() const;
  /// M^n z in closed form, for real eigenvalues too (which must differ).
  State power(Real n, State z) const;
  /// The form Q above, which is positive.
  Real invariant(State z) const { return -c * z.x * z.x + (a - d) * z.x * z.v + b * z.v * z.v; }
  /// The largest x on the ellipse Q = Q(z).
  Real amplitude(State z) const;
};

/// `damping_per_s` must be 0 for velocity Verlet, because its solver evaluates the force at the velocity before.
LinearMap linear_map(Method method, LinearMap::Real w2_per_s2, LinearMap::Real damping_per_s, LinearMap::Real h_s);
/// The undamped map of a solver that computes in float. Its constants (k / m, h, k h / m or h^2 k / m, h / 6, 1 / h: those
/// by which its method multiplies) are rounded to float, so it solves a problem that differs by up to 6e-8. This changes the
/// phase by 6e-8 d(theta) / d(ln h) per step, which near w h = 2 is ten times 6e-8 of theta: 2e-3 after a thousand periods.
/// What remains as a difference from this map is the rounding of the steps themselves.
LinearMap float_linear_map(Method method, double stiffness_N_per_m, double particle_mass_kg, double h_s);
/// The exact flow over h.
LinearMap exact_map(LinearMap::Real w2_per_s2, LinearMap::Real damping_per_s, LinearMap::Real h_s);

}  // namespace evenstep::internal
