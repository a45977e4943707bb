#pragma once
/// The methods whose substep needs more than a single loop over cells.

#include <memory>
#include <span>
#include <vector>

#include "cpu/cell_loops.h"
#include "src/tissue/tissue_solver.h"

namespace evenstep::internal {

/// A vector field as a structure of arrays, one entry per cell; at() starts at the lattice's first cell, like every loop
/// over cells.
template <class Real>
class CellField {
 public:
  explicit CellField(const Lattice& lattice)
      : first_(lattice.first), x_(lattice.cells), y_(lattice.cells), z_(lattice.cells) {}
  Vectors<Real> at() { return {x_.data() + first_, y_.data() + first_, z_.data() + first_}; }
  Vectors<const Real> at() const { return {x_.data() + first_, y_.data() + first_, z_.data() + first_}; }

 private:
  std::size_t first_;
  std::vector<Real> x_, y_, z_;
};

template <class Real>
Vectors<const Real> read(const Vectors<Real>& v) {
  return {v.x, v.y, v.z};
}

/// The data that a method computes with. It must outlive the method.
template <class Real>
struct MethodCells {
  const TissueScene& scene;
  const Lattice& lattice;
  const SceneFeatures& features;
  const TissueConstants<Real>& constants;  ///< those of the next substep
  const CellArrays<Real>& arrays;
  std::ptrdiff_t count() const { return static_cast<std::ptrdiff_t>(lattice.span); }
  /// Whether the scene has more than undamped springs of one material, so that a method must use the general version of its
  /// own loops.
  bool general() const { return features.regions || features.axial_damping || features.tool_forces(); }
};

template <class Real>
class CellMethod {
 public:
  virtual ~CellMethod() = default;
  /// Advances (u, v) by one substep. The tools, and the particles that they grab, move in a straight line.
  virtual void substep(const Vectors<Real>& u, const Vectors<Real>& v, const ToolStates& before,
                       const ToolStates& after) = 0;
  /// Called when the length of the substep has changed.
  virtual void set_substep(double substep_s) = 0;
};

/// Null for the methods that advance in a single loop over cells.
template <class Real>
std::unique_ptr<CellMethod<Real>> make_method(const MethodCells<Real>& cells, double substep_s);

template <class Real>
std::unique_ptr<CellMethod<Real>> make_runge_kutta(const MethodCells<Real>& cells, double substep_s);
template <class Real>
std::unique_ptr<CellMethod<Real>> make_implicit(const MethodCells<Real>& cells, double substep_s);
template <class Real>
std::unique_ptr<CellMethod<Real>> make_vertex_block_descent(const MethodCells<Real>& cells, double substep_s);

}  // namespace evenstep::internal
