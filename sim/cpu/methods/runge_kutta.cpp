// The classical Runge-Kutta method (Kutta 1901): for y = (u, v) and y' = (v, a(u, v)),
//   y <- y + h (k1 + 2 k2 + 2 k3 + k4) / 6,   k1 = y'(y), k2 = y'(y + h k1 / 2), k3 = y'(y + h k2 / 2), k4 = y'(y + h k3).
#include <algorithm>

#include "cpu/cell_forces.h"

namespace evenstep::internal {
namespace {

/// sum <- sum + weight k and stage <- start + reach k, for one component.
template <class Real>
EVENSTEP_WIDE void add_slope(std::ptrdiff_t count, const Real* __restrict start, const Real* __restrict slope, Real weight,
                             Real reach, Real* __restrict sum, Real* __restrict stage) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    sum[i] += weight * slope[i];
    stage[i] = start[i] + reach * slope[i];
  }
}

template <class Real>
class RungeKutta final : public CellMethod<Real> {
 public:
  RungeKutta(const MethodCells<Real>& cells, double substep_s)
      : cells_(cells),
        substep_s_(substep_s),
        stage_u_(cells.lattice),
        stage_v_(cells.lattice),
        slope_v_(cells.lattice),
        sum_u_(cells.lattice),
        sum_v_(cells.lattice) {}

  void set_substep(double substep_s) override { substep_s_ = substep_s; }

  void substep(const Vectors<Real>& u, const Vectors<Real>& v, const ToolStates& before, const ToolStates& after) override {
    const double h = substep_s_;
    const ToolStates start = tools_after(0, before, after), middle = tools_after(0.5, before, after);
    start_grabs(cells_, after, h, u, v);
    copy(u, stage_u_.at()), copy(u, sum_u_.at());
    copy(v, stage_v_.at()), copy(v, sum_v_.at());
    stage(u, v, start, h / 6, h / 2);
    stage(u, v, middle, h / 3, h / 2);
    stage(u, v, middle, h / 3, h);
    stage(u, v, after, h / 6, 0);
    copy(sum_u_.at(), u);
    copy(sum_v_.at(), v);
    end_grabs(cells_, after, u, v);
  }

 private:
  /// Adds the slope (stage_v, a) to the weighted sum, and moves on to the next stage.
  void stage(const Vectors<Real>& u, const Vectors<Real>& v, const ToolStates& tools, double weight_s, double reach_s) {
    accelerations<Real>(cells_, read(stage_u_.at()), read(stage_v_.at()), tools, slope_v_.at());
    const auto add = [&](const Vectors<Real>& start, const Vectors<Real>& slope, const Vectors<Real>& sum,
                         const Vectors<Real>& next) {
      const auto weight = static_cast<Real>(weight_s), reach = static_cast<Real>(reach_s);
      add_slope<Real>(cells_.count(), start.x, slope.x, weight, reach, sum.x, next.x);
      add_slope<Real>(cells_.count(), start.y, slope.y, weight, reach, sum.y, next.y);
      add_slope<Real>(cells_.count(), start.z, slope.z, weight, reach, sum.z, next.z);
    };
    add(u, stage_v_.at(), sum_u_.at(), stage_u_.at());
    add(v, slope_v_.at(), sum_v_.at(), stage_v_.at());
  }
  void copy(const Vectors<Real>& from, const Vectors<Real>& to) const {
    std::copy_n(from.x, cells_.count(), to.x);
    std::copy_n(from.y, cells_.count(), to.y);
    std::copy_n(from.z, cells_.count(), to.z);
  }

  MethodCells<Real> cells_;
  double substep_s_;
  CellField<Real> stage_u_, stage_v_, slope_v_, sum_u_, sum_v_;
};

}  // namespace

template <class Real>
std::unique_ptr<CellMethod<Real>> make_runge_kutta(const MethodCells<Real>& cells, double substep_s) {
  return std::make_unique<RungeKutta<Real>>(cells, substep_s);
}
template std::unique_ptr<CellMethod<float>> make_runge_kutta(const MethodCells<float>&, double);
template std::unique_ptr<CellMethod<double>> make_runge_kutta(const MethodCells<double>&, double);

}  // namespace evenstep::internal
