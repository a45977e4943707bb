// A plug-in in C++. FAULT says what is wrong with it. With "none" it is good and has nothing but a step.
#include <stdexcept>
#include <string_view>

#include "evenstep/plugins/plugin.h"

namespace {

constexpr std::string_view kFault = FAULT;
constexpr bool is(std::string_view fault) { return kFault == fault; }

int step(void*, const double* positions_m, double, double* forces_N, evenstep_error*) {
  if (is("throws")) throw std::runtime_error("out of cheese");
  if (is("throws_int")) throw 3;
  if (is("silent")) return 42;
  for (int axis = 0; axis < 3; ++axis) forces_N[axis] = -200 * positions_m[axis];
  return EVENSTEP_OK;
}
int create_device(const evenstep_device_request*, void**, evenstep_error*) { return EVENSTEP_OK; }

constexpr evenstep_solver_functions kSolver{.struct_size = sizeof(evenstep_solver_functions) - (is("table_size") ? 8 : 0),
                                            .step = is("no_step") ? nullptr : step};
constexpr evenstep_device_functions kDevice{.struct_size = sizeof(evenstep_device_functions), .create = create_device};

constexpr evenstep_map_functions kMap{.struct_size = sizeof(evenstep_map_functions) + (is("map_size") ? 8 : 0)};
constexpr evenstep_timing_functions kTiming{.struct_size = sizeof(evenstep_timing_functions) + (is("timing_size") ? 8 : 0)};

constexpr evenstep_plugin kPlugin{.abi = is("abi") ? 2 : EVENSTEP_ABI,
                                  .struct_size = sizeof(evenstep_plugin) + (is("size") ? 8 : 0),
                                  .name = is("no_name")      ? nullptr
                                          : is("empty_name") ? ""
                                                             : "faulty",
                                  .solver = is("empty") ? nullptr : &kSolver,
                                  .device = is("half_device") ? &kDevice : nullptr,
                                  .map = is("map_size") || is("half_map") ? &kMap : nullptr,
                                  .timing = is("timing_size") || is("half_timing") ? &kTiming : nullptr};

}  // namespace

#ifdef NO_SYMBOL
extern "C" EVENSTEP_EXPORT const evenstep_plugin* evenstep_plugin_v0(void);
extern "C" const evenstep_plugin* evenstep_plugin_v0(void) { return &kPlugin; }
#else
const evenstep_plugin* evenstep_plugin_v1(void) {
  if (is("entry_throws")) throw std::runtime_error("too early");
  return is("nothing") ? nullptr : &kPlugin;
}
#endif
