#pragma once
/// Puts grabbed particles where their tools are, for the methods whose own kernels do not, and reads what the tools feel,
/// once per step.

#include <array>
#include <span>
#include <vector>

#include "opencl/cell_buffers.h"

namespace evenstep::internal {

class ToolKernels {
 public:
  /// `watched` is TissueSolver::watched(); all arguments must outlive this.
  ToolKernels(const CellBuffers& cells, const std::vector<std::uint32_t>& watched, const ClCommands& commands);
  /// Call it after the program was built, for each direction of the ping-pong (0 or 1), with the displacement `u` and
  /// velocity `v` that it reads.
  void bind(std::size_t direction, const ClField& u, const ClField& v);
  bool any_grab() const { return grabbed_count_ > 0; }
  /// Adds three arguments: the cells that tools grab, their number, and how many of them belong to tool 0.
  void add_grabbed(BoundKernel& kernel) const;
  void enqueue_grabbed(const BoundKernel& kernel) const;

  void put_grabs(std::size_t direction, const ToolStates& tools);
  void read(std::size_t direction, const ToolStates& now, ToolReadings& readings);
  /// Computes the sums of a probe again, as if it had another radius.
  ProbeSums read_probe(std::size_t direction, std::size_t tool, const ToolStates& now, float radius_m);

 private:
  struct Kernels {
    BoundKernel grab, grab_force, coupling_force, displacements;
    std::array<BoundKernel, kMaxTools> probe;
  };
  void enqueue_probe(Kernels& kernels, std::size_t tool, const ToolStates& now, float radius_m);
  ProbeSums probe_result(std::span<const float> result, std::size_t tool) const;
  void bind_grab(Kernels& kernels, const ClField& u, const ClField& v) const;
  void bind_probe(BoundKernel& probe, std::size_t tool, const ClField& u);
  void take_result(std::span<const float> result, ToolReadings& readings) const;

  // The result contains the forces of the grabbed particles, then those of the coupled ones, the sums of each probe, and the
  // displacements of the watched cells.
  std::size_t probe_at(std::size_t tool) const {
    return 3 * (grabbed_count_ + coupled_count_) + (tool == 1 && cells_.is_probe(0) ? probe_size() : 0);
  }
  std::size_t probe_size() const { return cells_.chunks() * cells_.features.probe_values(); }
  std::size_t watched_at() const { return result_.size() - 3 * watched_.size(); }

  const CellBuffers& cells_;
  const std::vector<std::uint32_t>& watched_;
  const ClCommands& commands_;
  std::size_t grabbed_count_ = 0, coupled_count_ = 0;
  ClBuffer grabbed_, coupled_, watched_cells_, probe_cells_;
  ClResults result_;
  std::array<Kernels, 2> kernels_;
  std::array<BoundKernel, kMaxTools> probe_sums_;
  cl_uint radius_at_ = 0;  // among the arguments of probe_cells
};

}  // namespace evenstep::internal
