#pragma once
/// Implicit Euler on the device, with the same operations as cpu/methods/implicit.cpp (kernels/implicit.cl).

#include <vector>

#include "cpu/host_cells.h"
#include "cpu/method.h"
#include "opencl/cell_buffers.h"
#include "opencl/tool_kernels.h"

namespace evenstep::internal {

class ImplicitSolve {
 public:
  /// Construct it after the program was built. All arguments must outlive it; `u` and `v` are advanced in place.
  ImplicitSolve(const CellBuffers& cells, const ToolKernels& tools, const ClField& u, const ClField& v, double substep_s,
                const ClCommands& commands);
  void set_substep(double substep_s);
  /// One substep. Grabbed particles move with their velocity, and are then put where their tools are after the substep.
  void substep(const ToolStates& after);
  /// One iteration of preconditioned conjugate gradients. Returns the new r' D^-1 r.
  float iterate(float residual);
  void to_rest() const;

 private:
  void bind(const ClField& u, const ClField& v);
  float sum_products();

  const CellBuffers& cells_;
  const ToolKernels& tools_;
  const ClCommands& commands_;
  HostCells<float> host_cells_;
  MethodCells<float> all_;
  ClField x_, z_, r_, p_, q_;  // velocity, u0 + h x, residual, direction, A times it
  ClBuffer scale_buffer_, products_, product_sums_;
  std::vector<float> scale_, partial_sums_;  // 1 / D; per chunk
  BoundKernel aim_grabs_, begin_solve_, residual_, apply_system_, advance_solution_, advance_direction_, finish_solve_,
      chunk_sum_;
};

}  // namespace evenstep::internal
