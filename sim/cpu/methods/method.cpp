#include "cpu/method.h"

namespace evenstep::internal {

template <class Real>
std::unique_ptr<CellMethod<Real>> make_method(const MethodCells<Real>& cells, double substep_s) {
  switch (cells.scene.method) {
    case Method::symplectic_euler:
    case Method::velocity_verlet:
      return nullptr;
    case Method::rk4:
      return make_runge_kutta(cells, substep_s);
    case Method::implicit_euler:
    case Method::implicit_midpoint:
      return make_implicit(cells, substep_s);
    case Method::vertex_block_descent:
      return make_vertex_block_descent(cells, substep_s);
  }
  return nullptr;
}
template std::unique_ptr<CellMethod<float>> make_method(const MethodCells<float>&, double);
template std::unique_ptr<CellMethod<double>> make_method(const MethodCells<double>&, double);

}  // namespace evenstep::internal
