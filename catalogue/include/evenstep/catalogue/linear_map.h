#pragma once
/// What one step of a method does to a mode: (x, v) of a unit mass on a spring w^2 with damping d, step h. On a linear system
/// every method is such a 2 x 2 matrix M, and its n-th power is the exact answer for n steps: tests against it are sharp
/// however coarse the step.
///
///   symplectic Euler   v' = (1 - h d) v - h w^2 x,  x' = x + h v'                    det M = 1 - h d
///   velocity Verlet    v* = v - h w^2 x / 2,  x' = x + h v*,  v' = v* - h w^2 x' / 2     (d = 0)  det M = 1
///   Runge-Kutta        sum of (h A)^j / j!, j = 0 .. 4, A = [0 1; -w^2 -d]           det M = 1 - z^6/72 + z^8/576 (d = 0)
///   implicit Euler     (I - h A)^-1                                                   det M = 1 / (1 + h d + z^2)
///   implicit midpoint  (I - h A / 2)^-1 (I + h A / 2)                                 det M = 1 (d = 0)
/// with z = w h. With complex eigenvalues r exp(+- i theta), r^2 = det M:
///   M^n = r^n (cos(n theta) I + sin(n theta) / sin(theta) (M / r - cos(theta) I)),
/// and theta comes from its sine, sqrt(-b c - (a - d)^2 / 4) / r, where w h is so small that its cosine is 1. For symplectic
/// Euler that is sin(theta / 2) = w h / 2. The form Q = -c x^2 + (a - d) x v + b v^2 is multiplied by det M in every step: for a
/// symplectic method it is the energy that it conserves instead of the true one. (Hairer, Lubich, Wanner, Geometric Numerical
/// Integration, 2nd ed., IX.)

#include "evenstep/sim/scene.h"

namespace evenstep::internal {

/// z' = M z, z = (x, v), in long double: its rounding is 1/2000 of what is judged.
struct LinearMap {
  using Real = long double;
  Real a = 1, b = 0, c = 0, d = 1;  ///< [a b; c d]
  Real determinant = 1;             ///< in closed form, without the cancellation in a d - b c

  struct State {
    Real x = 0, v = 0;
  };
  State times(State z) const { return {a * z.x + b * z.v, c * z.x + d * z.v}; }
  /// Eigenvalues are complex: there is an angle, a conserved form and an amplitude.
  bool oscillates() const { return -b * c - (a - d) * (a - d) / 4 > 0; }
  Real angle() const;
  /// M^n z in closed form, for real eigenvalues too (which must differ).
  State power(Real n, State z) const;
  /// Q above; positive.
  Real invariant(State z) const { return -c * z.x * z.x + (a - d) * z.x * z.v + b * z.v * z.v; }
  /// Largest x on the ellipse Q = Q(z).
  Real amplitude(State z) const;
};

/// `damping_per_s` other than 0: not velocity Verlet (whose solver takes the force at the velocity before).
LinearMap linear_map(Method method, LinearMap::Real w2_per_s2, LinearMap::Real damping_per_s, LinearMap::Real h_s);
/// The same, undamped, of a solver that computes in float: its constants (k / m, h, k h / m or h^2 k / m, h / 6, 1 / h: whatever
/// its method multiplies with) are rounded to float, and so it solves a problem that is another by up to 6e-8. That turns the
/// phase by 6e-8 d(theta) / d(ln h) per step, which near w h = 2 is ten times theta's own part: after a thousand periods 2e-3.
/// What is left against this map is the rounding of the steps themselves.
LinearMap float_linear_map(Method method, double stiffness_N_per_m, double particle_mass_kg, double h_s);
/// The exact flow over h.
LinearMap exact_map(LinearMap::Real w2_per_s2, LinearMap::Real damping_per_s, LinearMap::Real h_s);

}  // namespace evenstep::internal
