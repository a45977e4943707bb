#include "opencl/implicit_solve.h"

#include "cpu/methods/implicit_system.h"
#include "src/tissue/iterations.h"

namespace evenstep::internal {

ImplicitSolve::ImplicitSolve(const CellBuffers& cells, const ToolKernels& tools, const ClField& u, const ClField& v,
                             double substep_s, const ClCommands& commands)
    : cells_(cells),
      tools_(tools),
      commands_(commands),
      host_cells_(cells.scene, cells.lattice, cells.features),
      all_{cells.scene, cells.lattice, cells.features, cells.constants, host_cells_.arrays()},
      scale_buffer_(commands.buffer(cells.lattice.span * sizeof(float))),
      products_(commands.buffer(cells.lattice.span * sizeof(float))),
      product_sums_(commands.buffer(cells.chunks() * sizeof(float))),
      scale_(cells.lattice.span),
      partial_sums_(cells.chunks()) {
  for (ClField* field : {&x_, &z_, &r_, &p_, &q_}) *field = commands.field(cells.lattice.cells);
  bind(u, v);
  set_substep(substep_s);
}

/// Arguments in the order of the kernels' parameters; set_substep() sets those that depend on the substep's length.
void ImplicitSolve::bind(const ClField& u, const ClField& v) {
  const ClBuffer& mass = cells_.features.regions ? cells_.mass : cells_.mobile;
  const cl_float4 none{};
  const cl_ulong first = cells_.lattice.first;
  const auto add_length = [](BoundKernel& kernel) {
    kernel.step_at = kernel.next();
    kernel.add(0.0f);
  };
  if (tools_.any_grab()) {
    aim_grabs_ = commands_.kernel("aim_grabs");
    tools_.add_grabbed(aim_grabs_);
    aim_grabs_.add(u, v);
    add_length(aim_grabs_);
    aim_grabs_.tools_at = aim_grabs_.next();
    aim_grabs_.add(none, none, none, none);
  }
  begin_solve_ = commands_.kernel("begin_solve");
  begin_solve_.add(u, v, cells_.mobile, x_, z_, first);
  add_length(begin_solve_);
  residual_ = commands_.kernel("residual");
  residual_.add(z_, x_, cells_.active, cells_.mobile);
  cells_.add_materials(residual_);
  cells_.add_tools(residual_);
  residual_.add(v, mass, scale_buffer_, r_, p_, products_);
  add_length(residual_);
  apply_system_ = commands_.kernel("apply_system");
  apply_system_.add(z_, cells_.active, cells_.mobile);
  if (cells_.features.regions) apply_system_.add(cells_.stiffness);
  cells_.add_tools(apply_system_);
  apply_system_.add(p_, mass, q_, products_);
  apply_system_.step_at = apply_system_.next();
  apply_system_.add(none, none);
  advance_solution_ = commands_.kernel("advance_solution");
  advance_solution_.add(p_, q_, scale_buffer_, x_, r_, products_, first);
  advance_direction_ = commands_.kernel("advance_direction");
  advance_direction_.add(r_, scale_buffer_, p_, first);
  finish_solve_ = commands_.kernel("finish_solve");
  finish_solve_.add(x_, u, v, first);
  add_length(finish_solve_);
  chunk_sum_ = commands_.kernel("chunk_sum");
  chunk_sum_.add(products_, product_sums_);
}

void ImplicitSolve::set_substep(double substep_s) {
  const SystemConstants<float> system(cells_.scene, substep_s);
  fill_inverse_diagonal(all_, system, substep_s, scale_);
  commands_.write(scale_, scale_buffer_);
  const ToolTerms<float> terms(all_, {}, substep_s);
  apply_system_.set(apply_system_.step_at, cl_float4{{system.inertia, system.stiffness, system.axial, 0}});
  apply_system_.set(apply_system_.step_at + 1, cl_float4{{terms.damping[0], terms.damping[1], 0, 0}});
  const auto h = static_cast<float>(substep_s);
  for (BoundKernel* kernel : {&aim_grabs_, &begin_solve_, &residual_, &finish_solve_})
    if (*kernel) kernel->set(kernel->step_at, h);
}

void ImplicitSolve::substep(const ToolStates& after) {
  if (aim_grabs_) {
    set_tool_states(aim_grabs_, aim_grabs_.tools_at, after);
    tools_.enqueue_grabbed(aim_grabs_);
  }
  commands_.enqueue(begin_solve_, cells_.lattice.span);
  cells_.set_tools(residual_, after);
  cells_.set_tools(apply_system_, after);
  commands_.enqueue(residual_, cells_.lattice.span);
  float residual = sum_products();
  const float floor = residual_floor(residual);
  for (int n = 0; n < iterations_of(cells_.scene) && !(residual <= floor); ++n) residual = iterate(residual);
  commands_.enqueue(finish_solve_, cells_.lattice.span);
}

float ImplicitSolve::iterate(float residual) {
  commands_.enqueue(apply_system_, cells_.lattice.span);
  const float curvature = sum_products();
  advance_solution_.set(advance_solution_.next(), curvature > 0 ? residual / curvature : 0.0f);
  commands_.enqueue(advance_solution_, cells_.lattice.span);
  const float left = sum_products();
  advance_direction_.set(advance_direction_.next(), left / residual);
  commands_.enqueue(advance_direction_, cells_.lattice.span);
  return left;
}

float ImplicitSolve::sum_products() {
  commands_.enqueue(chunk_sum_, cells_.chunks());
  commands_.read(product_sums_, partial_sums_);
  float total = 0;
  for (const float sum : partial_sums_) total += sum;
  return total;
}

void ImplicitSolve::to_rest() const {
  for (const ClField* field : {&x_, &z_, &p_})
    for (int axis = 0; axis < 3; ++axis) commands_.zero(field->axis(axis), cells_.lattice.cells * sizeof(float));
}

}  // namespace evenstep::internal
