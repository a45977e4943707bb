#pragma once
/// Which OpenCL devices this machine has, and which of them computes a scene. The choice changes how long a step takes, and
/// no bit of its result.

#include <cstddef>
#include <string>
#include <vector>

namespace evenstep {

struct OpenClListed {
  std::string platform, device;
  bool is_gpu = false;
};

/// The devices of all platforms, in the order of their drivers; looked for once per process. Throws SolverError if there is
/// none, with what to install.
const std::vector<OpenClListed>& opencl_devices();

/// The place in the list of the device to use. `part` is a part of "device (platform)"; the first device that fits is taken,
/// and a SolverError names all if none does. Without it: the first GPU if `prefer_gpu` and there is one,
/// otherwise PoCL's first device, otherwise the first of all.
std::size_t choose_opencl(const std::vector<OpenClListed>& there, const std::string& part, bool prefer_gpu);

/// "A (platform P); also there: B (Q); [scene] opencl_device = "a part of a name" chooses"
std::string opencl_text(const std::vector<OpenClListed>& there, std::size_t chosen);
/// What to say of a solver that runs on the processor while a GPU has nothing to do; empty if that is not so.
std::string idle_gpu_text(const std::vector<OpenClListed>& there, std::size_t chosen);

}  // namespace evenstep
