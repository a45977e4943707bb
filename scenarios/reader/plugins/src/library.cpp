#include "evenstep/plugins/library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstring>
#include <exception>
#include <filesystem>
#include <utility>
#include <vector>

#include "elf.h"
#include "excerpt.h"
#include "library_parts.h"

namespace evenstep {
namespace {

using namespace internal;

constexpr const char* kEntry = "evenstep_plugin_v1";
constexpr std::size_t kLongestName = 60;
constexpr const char* kOtherHeader = "build it with the plugin.h of this evenstep";

/// The names of the functions that a table must have, and whether it has them.
using Required = std::vector<std::pair<const char*, bool>>;
Required required(const evenstep_solver_functions& solver) { return {{"step", solver.step != nullptr}}; }
Required required(const evenstep_device_functions& device) {
  return {{"create", device.create != nullptr},
          {"read", device.read != nullptr},
          {"write", device.write != nullptr},
          {"stop", device.stop != nullptr}};
}
Required required(const evenstep_map_functions& map) {
  return {{"boundary", map.boundary != nullptr}, {"slot", map.slot != nullptr}};
}
Required required(const evenstep_timing_functions& timing) {
  return {{"create", timing.create != nullptr}, {"next", timing.next != nullptr}};
}

/// What is wrong with a table of functions; empty if nothing is, or there is none.
template <class Table>
std::string objection_to(const char* kind, const Table* table) {
  if (table == nullptr) return {};
  if (table->struct_size != sizeof(Table))
    return fmt::format("its table of {} functions has {} bytes, and here it has {}; {}", kind, table->struct_size,
                       sizeof(Table), kOtherHeader);
  for (const auto& [name, is_there] : required(*table)) {
    if (!is_there) return fmt::format("its {} has no function '{}', without which there is none", kind, name);
  }
  return {};
}

std::string objection_to(const evenstep_plugin* plugin) {
  if (plugin == nullptr) return fmt::format("its {}() returns nothing", kEntry);
  if (plugin->abi != EVENSTEP_ABI)
    return fmt::format("it was built for ABI {}, and this evenstep has {}; {}", plugin->abi, EVENSTEP_ABI, kOtherHeader);
  if (plugin->struct_size != sizeof *plugin)
    return fmt::format("its evenstep_plugin has {} bytes, and here it has {}; {}", plugin->struct_size, sizeof *plugin,
                       kOtherHeader);
  if (plugin->name == nullptr || *plugin->name == '\0') return "it has no name; set evenstep_plugin.name";
  if (plugin->solver == nullptr && plugin->device == nullptr && plugin->map == nullptr && plugin->timing == nullptr)
    return "it has no solver, device, map or timing";
  for (const std::string& objection : {objection_to("solver", plugin->solver), objection_to("device", plugin->device),
                                       objection_to("map", plugin->map), objection_to("timing", plugin->timing)}) {
    if (!objection.empty()) return objection;
  }
  return {};
}

/// The library's table, as its entry function gives it.
Result<const evenstep_plugin*, std::string> plugin_of(void* library) {
  void* const entry = dlsym(library, kEntry);
  if (entry == nullptr)
    return Failure(
        fmt::format("it exports no function {}; is it a plug-in, and made for this ABI ({})?", kEntry, EVENSTEP_ABI));
  try {
    return reinterpret_cast<decltype(&evenstep_plugin_v1)>(entry)();
  } catch (...) {
    return Failure(fmt::format("its {}() threw an exception", kEntry));
  }
}

}  // namespace

Result<Library, std::string> open_library(const std::string& path) {
  const auto failed = [&](const std::string& why) { return Failure(fmt::format("'{}': {}", path, why)); };
  if (const std::string objection = objection_to_library(path); !objection.empty())
    return Failure(fmt::format("'{}' {}", path, objection));
  // An absolute path: a bare name would be searched for in the folders of the system.
  void* const library = dlopen(std::filesystem::absolute(path).c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  if (library == nullptr) return failed(excerpt(dlerror(), 400));
  const Result<const evenstep_plugin*, std::string> plugin = plugin_of(library);
  if (!plugin) return failed(plugin.error());
  if (const std::string objection = objection_to(*plugin); !objection.empty()) return failed(objection);
  const evenstep_plugin& found = **plugin;
  Library parts;
  parts.name = excerpt({found.name, strnlen(found.name, kLongestName + 1)}, kLongestName);
  if (found.solver != nullptr) parts.solver = solver_factory(*found.solver);
  if (found.device != nullptr) parts.device = device_factory(*found.device);
  if (found.map != nullptr) parts.map = map_factory(*found.map);
  if (found.timing != nullptr) parts.timing = timing_factory(*found.timing);
  return parts;
}

}  // namespace evenstep
