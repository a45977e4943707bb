// Vertex block descent (Chen, Liu, Yang, Yuksel, Vertex Block Descent, SIGGRAPH 2024): implicit Euler as the minimum of
//   G(u) = sum m |u_i - y_i|^2 / (2 h^2) + m d |u_i - u0_i|^2 / (2 h) + springs' energy,    y = u0 + h v0 + h^2 g,
// by sweeps that move one particle at a time to the minimum of a quadratic model of G as a function of its own position.
// No spring joins particles of the same colour, so they could all move at once. The first guess is y; v1 = (u1 - u0) / h.
// Axial dampers, couplings and probes are part of G in the same way.
//
// The model uses the spring's Hessian without its negative part, as in implicit.cpp, so each 3 x 3 block is at least
// m (1 + h d) / h^2 times I, and so are the pivots of its L D L' decomposition. Pivots that rounding makes smaller are
// raised to this value, so no block is singular.
#include <algorithm>

#include "cpu/cell_forces.h"
#include "src/tissue/colours.h"
#include "src/tissue/iterations.h"

namespace evenstep::internal {
namespace {

/// Solves H dx = g for a symmetric H; pivots below `least` > 0 are raised to it.
template <class Real>
EVENSTEP_INLINE Vector<Real> solve_block(Real xx, Real xy, Real xz, Real yy, Real yz, Real zz, Real least,
                                         const Vector<Real>& g) {
  const Real d0 = xx > least ? xx : least;
  const Real l10 = xy / d0, l20 = xz / d0;
  const Real yy1 = yy - l10 * xy;
  const Real d1 = yy1 > least ? yy1 : least;
  const Real yz1 = yz - l10 * xz, l21 = yz1 / d1;
  const Real zz2 = zz - l20 * xz - l21 * yz1;
  const Real d2 = zz2 > least ? zz2 : least;
  const Real y = g.y - l10 * g.x, z = g.z - l20 * g.x - l21 * y;
  Vector<Real> dx;
  dx.z = z / d2;
  dx.y = y / d1 - l21 * dx.z;
  dx.x = g.x / d0 - l10 * dx.y - l20 * dx.z;
  return dx;
}

/// Constants of the model divided by m / h^2: stiffness = h^2 k / m, damping = h d, axial = c / (k h).
template <class Real>
struct BlockConstants {
  Real stiffness, damping, axial;
};

/// Computes the moves of the particles in `cells` to the minima of their models.
template <bool kGeneral, class Real>
EVENSTEP_WIDE void block_moves(std::ptrdiff_t count, const std::uint32_t* __restrict cells, const Vectors<const Real> u,
                               const Vectors<const Real> y, const Vectors<const Real> u0, const CellArrays<Real>& arrays,
                               const TissueConstants<Real>& constants, const BlockConstants<Real>& block,
                               const ToolTerms<Real>& tools, const Vectors<Real> moves) {
  const Real* const active = arrays.active;
  const Real* const mass = arrays.mass;
#pragma GCC ivdep
  for (std::ptrdiff_t n = 0; n < count; ++n) {
    const std::ptrdiff_t i = cells[n];
    // Nine local sums, not one struct of nine members: that would keep the compiler from vectorising (three times slower).
    Vector<Real> f;
    Real xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    const Vector<Real> moved{u.x[i] - u0.x[i], u.y[i] - u0.y[i], u.z[i] - u0.z[i]};
#pragma GCC unroll 18
    for (int s = 0; s < kNeighbours; ++s) {
      const std::ptrdiff_t j = i + arrays.offset[static_cast<std::size_t>(s)];
      const Vector<Real> d = to_neighbour(u, constants, i, j, s);
      const Real square = d.x * d.x + d.y * d.y + d.z * d.z + Real{FLT_MIN}, inverse_square = Real{1} / square;
      // Computed as in spring_force, so that it is exactly 0 at rest.
      const Real stretched = Real{1} - constants.length_m[static_cast<std::size_t>(s)] / std::sqrt(square);
      Real k = active[j];
      if constexpr (kGeneral) k *= spring_stiffness(arrays.stiffness[i], arrays.stiffness[j]);
      const Real across = k * (stretched > 0 ? stretched : Real{0});
      Real along = (k - across) * inverse_square, pull = k * stretched;
      if constexpr (kGeneral) {
        const Vector<Real> w{(u.x[j] - u0.x[j]) - moved.x, (u.y[j] - u0.y[j]) - moved.y, (u.z[j] - u0.z[j]) - moved.z};
        const Real damper = active[j] * block.axial * inverse_square;
        pull += damper * (w.x * d.x + w.y * d.y + w.z * d.z);
        along += damper;
      }
      f.x += pull * d.x;
      f.y += pull * d.y;
      f.z += pull * d.z;
      xx += across + along * d.x * d.x;
      yy += across + along * d.y * d.y;
      zz += across + along * d.z * d.z;
      xy += along * d.x * d.y;
      xz += along * d.x * d.z;
      yz += along * d.y * d.z;
    }
    if constexpr (kGeneral) {
#pragma GCC unroll 2
      for (std::size_t tool = 0; tool < kMaxTools; ++tool) {
        const auto& [x, w] = tools.at[tool];
        const Real held = arrays.held[tool][i], k = held * tools.stiffness[tool], b = held * tools.damping[tool];
        f.x += k * (x.x - u.x[i]) + b * (w.x * constants.step_s - moved.x);
        f.y += k * (x.y - u.y[i]) + b * (w.y * constants.step_s - moved.y);
        f.z += k * (x.z - u.z[i]) + b * (w.z * constants.step_s - moved.z);
        const Real across = k + b;
        const auto [d, factor, along] = probe_term(u, arrays, constants.tools[tool], tools.at[tool], i);
        f.x += factor * d.x;
        f.y += factor * d.y;
        f.z += factor * d.z;
        xx += across + along * d.x * d.x;
        yy += across + along * d.y * d.y;
        zz += across + along * d.z * d.z;
        xy += along * d.x * d.y;
        xz += along * d.x * d.z;
        yz += along * d.y * d.z;
      }
    }
    const Real stiffness = block.stiffness, inertia = mass[i] + block.damping;
    const Vector<Real> g{stiffness * f.x - (mass[i] * (u.x[i] - y.x[i]) + block.damping * moved.x),
                         stiffness * f.y - (mass[i] * (u.y[i] - y.y[i]) + block.damping * moved.y),
                         stiffness * f.z - (mass[i] * (u.z[i] - y.z[i]) + block.damping * moved.z)};
    const Vector<Real> move = solve_block(inertia + stiffness * xx, stiffness * xy, stiffness * xz, inertia + stiffness * yy,
                                          stiffness * yz, inertia + stiffness * zz, inertia, g);
    moves.x[n] = move.x;
    moves.y[n] = move.y;
    moves.z[n] = move.z;
  }
}

/// Saves u as u0 and sets u to the first guess y.
template <class Real>
EVENSTEP_WIDE void to_inertial_guess(std::ptrdiff_t count, const Real* __restrict mobile,
                                     const TissueConstants<Real>& constants, const Vectors<const Real> v,
                                     const Vectors<Real> u, const Vectors<Real> u0, const Vectors<Real> y) {
  const Real h = constants.step_s;
  const auto [gx, gy, gz] = constants.gravity;
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    u0.x[i] = u.x[i];
    u0.y[i] = u.y[i];
    u0.z[i] = u.z[i];
    y.x[i] = u.x[i] = u.x[i] + h * (v.x[i] + gx * mobile[i]);
    y.y[i] = u.y[i] = u.y[i] + h * (v.y[i] + gy * mobile[i]);
    y.z[i] = u.z[i] = u.z[i] + h * (v.z[i] + gz * mobile[i]);
  }
}

template <class Real>
EVENSTEP_WIDE void velocities(std::ptrdiff_t count, Real per_h, const Vectors<const Real> u, const Vectors<const Real> u0,
                              const Vectors<Real> v) {
#pragma GCC ivdep
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    v.x[i] = (u.x[i] - u0.x[i]) * per_h;
    v.y[i] = (u.y[i] - u0.y[i]) * per_h;
    v.z[i] = (u.z[i] - u0.z[i]) * per_h;
  }
}

template <class Real>
class VertexBlockDescent final : public CellMethod<Real> {
 public:
  VertexBlockDescent(const MethodCells<Real>& cells, double substep_s)
      : cells_(cells), substep_s_(substep_s), y_(cells.lattice), start_(cells.lattice) {
    for (std::int64_t site = 0; site < cells.scene.particle_count; ++site) {
      const auto i = static_cast<std::uint32_t>(cells.lattice.cell(site) - cells.lattice.first);
      if (cells.arrays.mobile[i] == 0) continue;
      const auto [x, y, z] = site_coordinates(cells.scene, site);
      colours_[static_cast<std::size_t>(colour_of(x, y, z))].push_back(i);
    }
    std::size_t most = 0;
    for (const auto& colour : colours_) most = std::max(most, colour.size());
    for (auto& component : moves_) component.resize(most);
  }

  void set_substep(double substep_s) override { substep_s_ = substep_s; }

  void substep(const Vectors<Real>& u, const Vectors<Real>& v, const ToolStates&, const ToolStates& after) override {
    start_grabs(cells_, after, substep_s_, u, v);
    to_inertial_guess<Real>(cells_.count(), cells_.arrays.mobile, cells_.constants, read(v), u, start_.at(), y_.at());
    end_grabs(cells_, after, u, v);
    for (int sweep = 0; sweep < iterations_of(cells_.scene); ++sweep) {
      for (const auto& colour : colours_) move(colour, u, after);
    }
    velocities<Real>(cells_.count(), static_cast<Real>(1 / substep_s_), read(u), read(start_.at()), v);
    end_grabs(cells_, after, u, v);
  }

 private:
  void move(const std::vector<std::uint32_t>& colour, const Vectors<Real>& u, const ToolStates& tools) {
    const TissueScene& scene = cells_.scene;
    const double h = substep_s_;
    const BlockConstants<Real> block{static_cast<Real>(h * h * scene.stiffness_N_per_m / scene.particle_mass_kg),
                                     static_cast<Real>(h * scene.damping_per_s),
                                     static_cast<Real>(scene.axial_damping_N_s_per_m / scene.stiffness_N_per_m / h)};
    const auto run = [&](const auto& moves_of) {
      moves_of(static_cast<std::ptrdiff_t>(colour.size()), colour.data(), read(u), read(y_.at()), read(start_.at()),
               general_arrays(cells_), cells_.constants, block, ToolTerms<Real>(cells_, tools, h),
               Vectors<Real>{moves_[0].data(), moves_[1].data(), moves_[2].data()});
    };
    cells_.general() ? run(block_moves<true, Real>) : run(block_moves<false, Real>);
    for (std::size_t n = 0; n < colour.size(); ++n) {
      u.x[colour[n]] += moves_[0][n];
      u.y[colour[n]] += moves_[1][n];
      u.z[colour[n]] += moves_[2][n];
    }
  }

  MethodCells<Real> cells_;
  double substep_s_;
  CellField<Real> y_, start_;
  std::array<std::vector<std::uint32_t>, kColours> colours_;  // per colour: mobile cells, counted from the lattice's first
  std::array<std::vector<Real>, 3> moves_;
};

}  // namespace

template <class Real>
std::unique_ptr<CellMethod<Real>> make_vertex_block_descent(const MethodCells<Real>& cells, double substep_s) {
  return std::make_unique<VertexBlockDescent<Real>>(cells, substep_s);
}
template std::unique_ptr<CellMethod<float>> make_vertex_block_descent(const MethodCells<float>&, double);
template std::unique_ptr<CellMethod<double>> make_vertex_block_descent(const MethodCells<double>&, double);

}  // namespace evenstep::internal
