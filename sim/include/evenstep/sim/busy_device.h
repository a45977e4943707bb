#pragma once
/// Keeps the compute device busy without a scene: a kernel that fills the device and computes nothing that anybody needs.
/// It stands for other work on the device, such as a visualization. It never sees a clock: the caller finds out how long a
/// round takes here.

#include <cstdint>
#include <memory>
#include <string_view>

#include "evenstep/sim/solver.h"

namespace evenstep {

class BusyDevice {
 public:
  virtual ~BusyDevice() = default;
  /// One launch, in which every work item goes through a loop `rounds` times; waits until it is done. `rounds` is at least 1
  /// and at most 1e9. Only one thread may call it at a time. Throws SolverError.
  virtual void run(std::int64_t rounds) = 0;
};

/// Uses the device that a solver with these options has. Throws SolverError like make_solver. The kernel has run once before
/// this returns.
std::unique_ptr<BusyDevice> make_busy_device(const SolverOptions& options = {});
/// What a scenario can have instead, in a build without OpenCL.
inline constexpr std::string_view kInsteadOfBurning = "write a length alone, without \"burn\"";

}  // namespace evenstep
