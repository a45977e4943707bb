// Implicit Euler (Baraff and Witkin, Large Steps in Cloth Simulation, 1998) and implicit midpoint.
//
// Both compute the velocity x with which the particles move during the substep, u1 = u0 + h x:
//   M (x - v0) = q F(u0 + q x, x),    q = h for implicit Euler, v1 = x; q = h/2 for implicit midpoint, v1 = 2 x - v0.
// A Newton step from x solves A dx = q F(u0 + q x, x) - M (x - v0), A = M + q C + q^2 K, where K and C are the negative
// derivatives of the forces. Implicit Euler is a single Newton step, from x = 0: with free particles where they are and
// grabbed ones where they will be.
//
// A spring's k (n n' + (1 - L/|d|) (I - n n')) is used without its negative part, the buckling of a compressed spring:
// k (n n' + max(0, 1 - L/|d|) (I - n n')). So A is symmetric and at least M, whatever the configuration and h.
//
// The conjugate gradients begin at dx = 0 and run a fixed number of iterations. Their result is exact within the subspace
// that they have spanned: x' A x = x' (M v0 - q K u0) for linear springs and x = 0 at the start. That alone gives
//   E1 = E0 - (h^2 x'K x + (x - v0)' M (x - v0)) / 2    for implicit Euler, however few iterations there are:
// an unfinished solve is never unstable, it only moves more slowly than the scene should. (Begun at x = v0 it can gain
// energy.) Implicit midpoint, for which E1 = E0, takes a second Newton step to reach its order, and keeps the energy only as
// far as the conjugate gradients converge and the springs are nearly linear: from a block crushed to a plane, with
// k = 2e5 N/m in steps of 1 ms, it stays finite but gains energy. Measured on 10^3 particles with a tool dragged at 0.1 m/s
// in steps of 1 ms: for k from 2 to 2e5 N/m, 20 iterations of implicit Euler give the force of a full solve to within 1e-3;
// so do 40 of implicit midpoint, a quarter of them in its first Newton step.
#include <algorithm>

#include "cpu/methods/implicit_system.h"
#include "src/tissue/iterations.h"

namespace evenstep::internal {
namespace {

/// The sum of one value per cell: over fixed chunks, then over the chunks in order. Eight chunks are summed at a time,
/// because their sums do not depend on each other.
template <class Real>
EVENSTEP_WIDE Real chunked_sum(std::ptrdiff_t count, const Real* __restrict values) {
  constexpr auto chunk = static_cast<std::ptrdiff_t>(kChunk), kAtOnce = std::ptrdiff_t{8};
  Real total = 0;
  for (std::ptrdiff_t begin = 0; begin < count; begin += kAtOnce * chunk) {
    const std::ptrdiff_t chunks = std::min(kAtOnce, (count - begin) / chunk);
    Real sums[kAtOnce] = {};
    if (chunks == kAtOnce) {
      for (std::ptrdiff_t n = 0; n < chunk; ++n)
        for (std::ptrdiff_t c = 0; c < kAtOnce; ++c) sums[c] += values[begin + c * chunk + n];
    } else {
      for (std::ptrdiff_t c = 0; c < chunks; ++c)
        for (std::ptrdiff_t n = 0; n < chunk; ++n) sums[c] += values[begin + c * chunk + n];
    }
    for (std::ptrdiff_t c = 0; c < chunks; ++c) total += sums[c];
  }
  return total;
}

/// q = A p, and p . q of every cell. `p` must be zero for particles that do not move by their forces.
template <bool kGeneral, class Real>
EVENSTEP_WIDE void apply_system(std::ptrdiff_t count, const Vectors<const Real> u, const Vectors<const Real> p,
                                const CellArrays<Real>& cells, const TissueConstants<Real>& constants,
                                const SystemConstants<Real>& system, const ToolTerms<Real>& tools, const Vectors<Real> q,
                                Real* __restrict products) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    Vector<Real> sum;
#pragma GCC unroll 18
    for (int s = 0; s < kNeighbours; ++s) {
      const std::ptrdiff_t j = i + cells.offset[static_cast<std::size_t>(s)];
      const Vector<Real> d = to_neighbour(u, constants, i, j, s);
      const Vector<Real> w{p.x[i] - p.x[j], p.y[i] - p.y[j], p.z[i] - p.z[j]};
      const Real inverse = Real{1} / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN});
      const Real stretched = Real{1} - constants.length_m[static_cast<std::size_t>(s)] * inverse;
      Real across = stretched > 0 ? stretched : Real{0}, along = Real{1} - across;
      if constexpr (kGeneral) {
        const Real k = spring_stiffness(cells.stiffness[i], cells.stiffness[j]);
        across *= k;
        along = k * along + system.axial;
      }
      along *= (d.x * w.x + d.y * w.y + d.z * w.z) * inverse * inverse;
      sum.x += cells.active[j] * (across * w.x + along * d.x);
      sum.y += cells.active[j] * (across * w.y + along * d.y);
      sum.z += cells.active[j] * (across * w.z + along * d.z);
    }
    if constexpr (kGeneral) {
#pragma GCC unroll 2
      for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
        const auto [d, factor, stiffness] = probe_term(u, cells, constants.tools[tool], tools.at[tool], i);
        const Real along = stiffness * (d.x * p.x[i] + d.y * p.y[i] + d.z * p.z[i]);
        const Real held = cells.held[tool][i] * (tools.stiffness[tool] + tools.damping[tool]);
        sum.x += held * p.x[i] + along * d.x;
        sum.y += held * p.y[i] + along * d.y;
        sum.z += held * p.z[i] + along * d.z;
      }
    }
    const Real inertia = system.inertia_of(cells.mass[i], cells.mobile[i]), stiffness = system.stiffness * cells.mobile[i];
    q.x[i] = inertia * p.x[i] + stiffness * sum.x;
    q.y[i] = inertia * p.y[i] + stiffness * sum.y;
    q.z[i] = inertia * p.z[i] + stiffness * sum.z;
    products[i] = p.x[i] * q.x[i] + p.y[i] * q.y[i] + p.z[i] * q.z[i];
  }
}

/// r = M (q a - (x - v0)) divided by the scene's particle mass, p = r / D, and r . p of every cell.
template <class Real>
EVENSTEP_WIDE void start_residual(std::ptrdiff_t count, const Vectors<const Real> a, const Vectors<const Real> x,
                                  const Vectors<const Real> v, const Real* __restrict mass, const Real* __restrict scale,
                                  Real q, const Vectors<Real> r, const Vectors<Real> p, Real* __restrict products) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    r.x[i] = mass[i] * (q * a.x[i] - (x.x[i] - v.x[i]));
    r.y[i] = mass[i] * (q * a.y[i] - (x.y[i] - v.y[i]));
    r.z[i] = mass[i] * (q * a.z[i] - (x.z[i] - v.z[i]));
    p.x[i] = scale[i] * r.x[i];
    p.y[i] = scale[i] * r.y[i];
    p.z[i] = scale[i] * r.z[i];
    products[i] = r.x[i] * p.x[i] + r.y[i] * p.y[i] + r.z[i] * p.z[i];
  }
}

/// x <- x + alpha p, r <- r - alpha q, and r . r / D of every cell.
template <class Real>
EVENSTEP_WIDE void advance_solution(std::ptrdiff_t count, Real alpha, const Vectors<const Real> p,
                                    const Vectors<const Real> q, const Real* __restrict scale, const Vectors<Real> x,
                                    const Vectors<Real> r, Real* __restrict products) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    x.x[i] += alpha * p.x[i];
    x.y[i] += alpha * p.y[i];
    x.z[i] += alpha * p.z[i];
    r.x[i] -= alpha * q.x[i];
    r.y[i] -= alpha * q.y[i];
    r.z[i] -= alpha * q.z[i];
    products[i] = scale[i] * (r.x[i] * r.x[i] + r.y[i] * r.y[i] + r.z[i] * r.z[i]);
  }
}

/// p <- r / D + beta p.
template <class Real>
EVENSTEP_WIDE void advance_direction(std::ptrdiff_t count, Real beta, const Vectors<const Real> r,
                                     const Real* __restrict scale, const Vectors<Real> p) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    p.x[i] = scale[i] * r.x[i] + beta * p.x[i];
    p.y[i] = scale[i] * r.y[i] + beta * p.y[i];
    p.z[i] = scale[i] * r.z[i] + beta * p.z[i];
  }
}

/// to <- from + factor step.
template <class Real>
EVENSTEP_WIDE void add_scaled(std::ptrdiff_t count, const Vectors<const Real> from, Real factor,
                              const Vectors<const Real> step, const Vectors<Real> to) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    to.x[i] = from.x[i] + factor * step.x[i];
    to.y[i] = from.y[i] + factor * step.y[i];
    to.z[i] = from.z[i] + factor * step.z[i];
  }
}

/// x = v for particles that do not move by their forces, otherwise 0 (never -0, because adding 0 would change that).
template <class Real>
EVENSTEP_WIDE void known_velocities(std::ptrdiff_t count, const Vectors<const Real> v, const Real* __restrict mobile,
                                    const Vectors<Real> x) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    x.x[i] = mobile[i] > 0 ? Real{0} : v.x[i];
    x.y[i] = mobile[i] > 0 ? Real{0} : v.y[i];
    x.z[i] = mobile[i] > 0 ? Real{0} : v.z[i];
  }
}

/// u <- u + h x and v <- (1 + extrapolate) x - extrapolate v.
template <class Real>
EVENSTEP_WIDE void finish(std::ptrdiff_t count, Real h, Real extrapolate, const Vectors<const Real> x, const Vectors<Real> u,
                          const Vectors<Real> v) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    u.x[i] += h * x.x[i];
    u.y[i] += h * x.y[i];
    u.z[i] += h * x.z[i];
    v.x[i] = x.x[i] + extrapolate * (x.x[i] - v.x[i]);
    v.y[i] = x.y[i] + extrapolate * (x.y[i] - v.y[i]);
    v.z[i] = x.z[i] + extrapolate * (x.z[i] - v.z[i]);
  }
}

template <class Real>
class Implicit final : public CellMethod<Real> {
 public:
  Implicit(const MethodCells<Real>& cells, double substep_s)
      : cells_(cells),
        is_midpoint_(cells.scene.method == Method::implicit_midpoint),
        x_(cells.lattice),
        z_(cells.lattice),
        r_(cells.lattice),
        p_(cells.lattice),
        q_(cells.lattice),
        scale_(cells.lattice.span),
        products_(cells.lattice.span) {
    set_substep(substep_s);
  }

  void set_substep(double substep_s) override {
    substep_s_ = substep_s;
    reach_s_ = is_midpoint_ ? substep_s / 2 : substep_s;
    system_ = SystemConstants<Real>(cells_.scene, reach_s_);
    fill_inverse_diagonal(cells_, system_, reach_s_, scale_);
  }

  void substep(const Vectors<Real>& u, const Vectors<Real>& v, const ToolStates& before, const ToolStates& after) override {
    start_grabs(cells_, after, substep_s_, u, v);
    known_velocities<Real>(cells_.count(), read(v), cells_.arrays.mobile, x_.at());
    const ToolStates tools = is_midpoint_ ? tools_after(0.5, before, after) : after;
    const int iterations = iterations_of(cells_.scene), at_first = is_midpoint_ ? iterations / 4 : 0;
    if (at_first > 0) newton_step(read(u), read(v), tools, at_first);
    newton_step(read(u), read(v), tools, iterations - at_first);
    finish<Real>(cells_.count(), static_cast<Real>(substep_s_), is_midpoint_ ? Real{1} : Real{0}, read(x_.at()), u, v);
    end_grabs(cells_, after, u, v);
  }

 private:
  void newton_step(const Vectors<const Real>& u, const Vectors<const Real>& v, const ToolStates& tools, int iterations) {
    const auto q = static_cast<Real>(reach_s_);
    add_scaled<Real>(cells_.count(), u, q, read(x_.at()), z_.at());
    accelerations<Real>(cells_, read(z_.at()), read(x_.at()), tools, q_.at());
    start_residual<Real>(cells_.count(), read(q_.at()), read(x_.at()), v, cells_.arrays.mass, scale_.data(), q, r_.at(),
                         p_.at(), products_.data());
    Real residual = chunked_sum<Real>(cells_.count(), products_.data());
    const Real floor = residual_floor(residual);
    const ToolTerms<Real> terms(cells_, tools, reach_s_);
    for (int n = 0; n < iterations && !(residual <= floor); ++n) residual = iterate(terms, residual);
  }

  /// One iteration of preconditioned conjugate gradients. Returns the new r' D^-1 r.
  Real iterate(const ToolTerms<Real>& tools, Real residual) {
    const auto apply = cells_.general() ? apply_system<true, Real> : apply_system<false, Real>;
    apply(cells_.count(), read(z_.at()), read(p_.at()), general_arrays(cells_), cells_.constants, system_, tools, q_.at(),
          products_.data());
    const Real curvature = chunked_sum<Real>(cells_.count(), products_.data());
    const Real alpha = curvature > 0 ? residual / curvature : Real{0};
    advance_solution<Real>(cells_.count(), alpha, read(p_.at()), read(q_.at()), scale_.data(), x_.at(), r_.at(),
                           products_.data());
    const Real left = chunked_sum<Real>(cells_.count(), products_.data());
    advance_direction<Real>(cells_.count(), left / residual, read(r_.at()), scale_.data(), p_.at());
    return left;
  }

  MethodCells<Real> cells_;
  bool is_midpoint_;
  double substep_s_ = 0, reach_s_ = 0;  // h, q
  SystemConstants<Real> system_;
  CellField<Real> x_, z_, r_, p_, q_;   // velocity, u0 + q x, residual, direction, A times it
  std::vector<Real> scale_, products_;  // 1 / D; one value per cell to be summed
};

}  // namespace

template <class Real>
std::unique_ptr<CellMethod<Real>> make_implicit(const MethodCells<Real>& cells, double substep_s) {
  return std::make_unique<Implicit<Real>>(cells, substep_s);
}
template std::unique_ptr<CellMethod<float>> make_implicit(const MethodCells<float>&, double);
template std::unique_ptr<CellMethod<double>> make_implicit(const MethodCells<double>&, double);

}  // namespace evenstep::internal
