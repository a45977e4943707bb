#pragma once
/// The parts in a shared object (plugin.h), as if the program had registered them.

#include <string>

#include "evenstep/device/foreign_device.h"
#include "evenstep/remap/foreign_map.h"
#include "evenstep/scheduler/foreign_timing.h"
#include "evenstep/sim/foreign_solver.h"
#include "evenstep/time/result.h"

namespace evenstep {

/// The factory of each part that the library has; empty functions for those that it does not have.
struct Library {
  std::string name;  ///< as it calls itself
  SolverFactory solver;
  DeviceFactory device;
  MapFactory map;
  TimingFactory timing;
};

/// Opens the file at this path, and nothing else: no folder is searched. Other libraries do not see its symbols, and all
/// symbols that it needs must exist. It stays loaded until the program ends, because there is no way to find the threads and
/// exit handlers that it may have made. Opening the same file again gives the same library. Errors in words, with what to
/// do: no such file, not a shared object for this machine, a symbol that is missing, another ABI, a size that is not that of
/// the header, a required function that is missing.
Result<Library, std::string> open_library(const std::string& path);

}  // namespace evenstep
