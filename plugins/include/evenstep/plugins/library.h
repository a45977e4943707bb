#pragma once
/// The parts in a shared object (plugin.h), as if the program had registered them.

#include <string>

#include "evenstep/device/foreign_device.h"
#include "evenstep/remap/foreign_map.h"
#include "evenstep/scheduler/foreign_timing.h"
#include "evenstep/sim/foreign_solver.h"
#include "evenstep/time/result.h"

namespace evenstep {

/// What makes each part that the library has; empty functions for those that it does not have.
struct Library {
  std::string name;  ///< as it calls itself
  SolverFactory solver;
  DeviceFactory device;
  MapFactory map;
  TimingFactory timing;
};

/// Opens the file at this path, and nothing else: no folder is searched. Its symbols are seen by nobody else, all of them
/// must be there, and it stays loaded until the program ends, because threads and exit handlers that it has made could not
/// be found. Opening the same file again gives the same library. Errors in words, with what to do: no file, no shared
/// object of this machine, a symbol that is missing, another ABI, a size that is not that of the header, a required
/// function that is missing.
Result<Library, std::string> open_library(const std::string& path);

}  // namespace evenstep
