#include "evenstep/sim/opencl_devices.h"

#include <fmt/format.h>

#include <algorithm>

#include "evenstep/sim/solver.h"

namespace evenstep {
namespace {

std::string name_of(const OpenClListed& one) { return fmt::format("{} ({})", one.device, one.platform); }

}  // namespace

std::size_t choose_opencl(const std::vector<OpenClListed>& there, const std::string& part, bool prefer_gpu) {
  const auto first = [&](const auto& fits) {
    return static_cast<std::size_t>(std::find_if(there.begin(), there.end(), fits) - there.begin());
  };
  const auto has = [](const std::string& name, const std::string& wanted) { return name.find(wanted) != std::string::npos; };
  if (!part.empty()) {
    const std::size_t named = first([&](const OpenClListed& one) { return has(name_of(one), part); });
    if (named < there.size()) return named;
    std::string known;
    for (const OpenClListed& one : there)
      known += fmt::format("{}'{}' ({})", known.empty() ? "" : ", ", one.device, one.platform);
    throw SolverError(SolverFault::unavailable, fmt::format("no OpenCL device or platform is called '{}'", part),
                      "a part of one of the names " + known);
  }
  const std::size_t gpu = first([](const OpenClListed& one) { return one.is_gpu; });
  if (prefer_gpu && gpu < there.size()) return gpu;
  const std::size_t pocl = first([&](const OpenClListed& one) { return has(one.platform, "Portable Computing Language"); });
  return pocl < there.size() ? pocl : 0;
}

std::string opencl_text(const std::vector<OpenClListed>& there, std::size_t chosen) {
  std::string others;
  for (std::size_t n = 0; n < there.size(); ++n)
    if (n != chosen) others += (others.empty() ? "; also there: " : ", ") + name_of(there[n]);
  return name_of(there[chosen]) + others + (others.empty() ? "" : "; [scene] opencl_device = \"a part of a name\" chooses");
}

std::string idle_gpu_text(const std::vector<OpenClListed>& there, std::size_t chosen) {
  const auto gpu = std::find_if(there.begin(), there.end(), [](const OpenClListed& one) { return one.is_gpu; });
  if (there[chosen].is_gpu || gpu == there.end()) return "";
  return fmt::format(
      "the solver runs on the processor, by {}, and a GPU has nothing to do: [scene] opencl_device = \"{}\" uses it, with "
      "the same results",
      name_of(there[chosen]), gpu->device);
}

}  // namespace evenstep
