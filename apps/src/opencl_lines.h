#pragma once
/// Which OpenCL device computes a scenario's scene, for the person who runs it.

#include <atomic>
#include <string>

#include "evenstep/format/reader.h"
#include "evenstep/harness/run.h"

namespace evenstep::app {

/// Whether the scene is one that OpenCL computes.
bool uses_opencl(const Scenario& scenario);
/// The device, which others there are, and the key that chooses; empty where OpenCL computes nothing. Where it has no
/// device, why.
std::string opencl_line(const Scenario& scenario);
/// Says once per process that a GPU has nothing to do while the processor runs the solver.
void warn_of_idle_gpu(const Scenario& scenario);

/// The OpenCL devices of this machine, for `devices`; a line that says why if there are none.
void print_opencl_devices();
/// `devices --opencl`: the same alone, as text or JSON, or each of them checked.
ExitCode opencl_devices_command(bool check, bool json, const std::atomic<bool>& interrupted, const Registry& registry);

}  // namespace evenstep::app
